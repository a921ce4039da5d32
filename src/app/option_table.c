#include "app/option_table.h"

#include "app/camera_string.h"
#include "app/layers.h"
#include "app/option_values.h"

#define V (1u << COMMAND_VIEW)
#define R (1u << COMMAND_RENDER)
#define F (1u << COMMAND_FLY)
#define M (1u << COMMAND_IMPORT)
#define N (1u << COMMAND_INFO)
#define C (1u << COMMAND_COMPARE)
#define X (1u << COMMAND_EXPORT)

#define AT(member)               offsetof(struct options, member)
#define FLAG(member)             OPTION_FLAG, AT(member), 0, 0, NULL, NULL
#define UNFLAG(member)           OPTION_UNFLAG, AT(member), 0, 0, NULL, NULL
#define TEXT(member, what)       OPTION_TEXT, AT(member), 0, 0, NULL, what
#define NUMBER(member, a, b, p)  OPTION_NUMBER, AT(member), a, b, NULL, p
#define INTEGER(member, a, b, p) OPTION_INTEGER, AT(member), a, b, NULL, p
#define VALUE(function, what)    OPTION_VALUE, 0, 0, 0, function, what
#define OPTIONAL(function, what) OPTION_OPTIONAL, 0, 0, 0, function, what

// clang-format off
const struct option_spec option_table[] = {
    {"height", 0, M, GROUP_IMPORT, OPTIONAL(option_height_layer, "RASTER..."),
     "the rasters that follow are heights, in metres; on top lies the finest, of equals the last given. "
     "A name may be a pattern in quotes, such as 'dem/*.tif'"},
    {"color", 0, M, GROUP_IMPORT, OPTIONAL(option_color_layer, "RASTER..."),
     "the rasters that follow are colour (RGB or RGBA)"},
    {"night", 0, M, GROUP_IMPORT, OPTIONAL(option_night_layer, "RASTER..."),
     "the rasters that follow are lights seen at night"},
    {"vertical", 0, M, GROUP_IMPORT, VALUE(option_vertical, "DATUM"),
     "heights of the rasters that follow stand above this: ellipsoid, egm96, egm2008 (mean sea level), EPSG:n, or "
     "declared: what each says (default; the ellipsoid if it says nothing)"},
    {"priority", 0, M, GROUP_IMPORT, INTEGER(source_priority, -1000, 1000, "N"),
     "the rasters that follow lie on top of all of a lower priority, -1000..1000 (default 0)"},
    {"feather", 0, M, GROUP_IMPORT, VALUE(option_feather, "auto|Wm|N"),
     "blend the borders of finer rasters over a sample of the coarser one (auto, default), over W metres (500m), or over N of "
     "their own samples, 0..255 (0: hard edges); the edges of holes over 8 of their own samples, or N"},
    {"codec", 0, M, GROUP_IMPORT, VALUE(option_codec, "CODEC"),
     "how heights are stored: lossless (on a grid, default), exact (as floats, at many times the size) or bounded: as "
     "what each tile adds to its parent, off by at most --max-error"},
    {"max-error", 0, M, GROUP_IMPORT, NUMBER(max_error, 0x1p-8, 4096, "M"),
     "with --codec bounded: the greatest error of any height, in metres"},
    {"quantum", 0, M, GROUP_IMPORT, NUMBER(quantum, 0x1p-12, 256, "M"),
     "step of the grid of heights, rounded down to a power of two; heights are at most half of it off "
     "(default: 1/2048 of the distance of a zoom's samples, 1/64 to 1 m; at the poles 1/64 m)"},
    {"body", 0, M, GROUP_IMPORT, VALUE(option_body, "BODY"),
     "earth (WGS84, default), moon, mars, or a JSON file with \"equatorialRadius\" and \"polarRadius\" in metres"},
    {"bounds", 0, M, GROUP_IMPORT, VALUE(option_bounds, "W,S,E,N"),
     "import only this part, in degrees; W > E crosses the antimeridian (default: all that the rasters cover)"},
    {"name", 0, M, GROUP_IMPORT, TEXT(name, "TEXT"),
     "name of the planet (default: the body, else the output's file name)"},
    {"attribution", 0, M, GROUP_IMPORT, TEXT(attribution, "TEXT"),
     "who is to be credited for the data; shown with every picture"},
    {"earth", 0, M, GROUP_IMPORT, FLAG(earth),
     "make the default Earth from the atlas in Debian's package marble-qt-data"},
    {"bathymetry", 0, M, GROUP_IMPORT, FLAG(bathymetry),
     "with --earth: keep the sea floor (default: the sea lies flat at 0 m)"},
    {"atlas", 0, M, GROUP_IMPORT, TEXT(atlas_dir, "DIR"),
     "with --earth: where the atlas's maps are (default /usr/share/marble/data/maps)"},
    {"add", 0, M, GROUP_IMPORT, FLAG(add),
     "put the rasters on top of the finished planet -o; only the tiles they touch are made anew, stored as its others are"},
    {"resume", 0, M, GROUP_IMPORT, FLAG(resume), "go on with an import that was interrupted"},
    {"estimate", 0, M, GROUP_IMPORT, FLAG(estimate),
     "say how many tiles, bytes and seconds the import takes, measured on a few tiles, and stop"},
    {"force", 0, M | X, GROUP_IMPORT, FLAG(force), "replace the output if it exists"},

    {"lat", 0, V | R | C, GROUP_CAMERA, NUMBER(camera.lat_deg, -90, 90, "DEG"),
     "geodetic latitude, -90..90 (default 20)"},
    {"lon", 0, V | R | C, GROUP_CAMERA, NUMBER(camera.lon_deg, -360, 360, "DEG"),
     "longitude, east positive, -360..360 (default 10)"},
    {"alt", 0, V | R | C, GROUP_CAMERA, NUMBER(camera.alt_m, CAMERA_ALT_MIN, CAMERA_ALT_MAX, "M"),
     "altitude above the ellipsoid in metres (default: pi radii, 20,000 km over the Earth)"},
    {"above-ground", 0, V | R | C, GROUP_CAMERA, NUMBER(above_ground_m, 0.5, CAMERA_ALT_MAX, "M"),
     "altitude above the terrain in metres, instead of --alt"},
    {"heading", 0, V | R | C, GROUP_CAMERA, NUMBER(camera.heading_deg, -360, 360, "DEG"),
     "clockwise from north (default 0)"},
    {"pitch", 0, V | R | C, GROUP_CAMERA, NUMBER(camera.pitch_deg, -90, 90, "DEG"),
     "0 is the horizon, -90 straight down (default -90)"},
    {"roll", 0, V | R | C, GROUP_CAMERA, NUMBER(camera.roll_deg, -180, 180, "DEG"), "clockwise (default 0)"},
    {"fov", 0, V | R | C, GROUP_CAMERA, NUMBER(camera.fov_deg, CAMERA_FOV_MIN, CAMERA_FOV_MAX, "DEG"),
     "vertical field of view, 0.01..179 (default 60)"},
    {"camera", 0, V | R | C, GROUP_CAMERA, VALUE(option_camera, "TEXT"),
     "all at once: lat,lon,alt[,heading,pitch[,roll[,fov]]] or a geo: URI with ;heading= ;pitch= ;roll= ;fov="},

    {"path", 0, F | C, GROUP_FLIGHT, TEXT(path, "FILE"),
     "flight in JSON: key views with time, lat, lon, alt or aboveGround, heading, pitch"},
    {"fps", 0, F | C, GROUP_FLIGHT, NUMBER(fps, 0.01, 1000, "N"),
     "frames for each second of flight (default 30); compare: with --modes, flicker is between a frame and the next of so many"},
    {"start", 0, F | C, GROUP_FLIGHT, NUMBER(start_s, 0, 1e6, "S"), "begin at this second of the flight (default 0)"},
    {"end", 0, F | C, GROUP_FLIGHT, NUMBER(end_s, 0, 1e6, "S"), "end at this second (default: the flight's end)"},
    {"frames", 0, C, GROUP_FLIGHT, INTEGER(frames, 1, 100000, "N"),
     "with --path: compare so many frames, evenly spaced from start to end, 1..100000 (default 10)"},

    {"size", 0, V | R | F | C, GROUP_PICTURE, VALUE(option_size, "WxH"),
     "pixels, 1..16384 each (default 1280x960; fly: 1280x720, view: 1280x800)"},
    {"samples", 0, R | F | C, GROUP_PICTURE, INTEGER(samples, 1, 8, "N"),
     "supersampling of PNGs, and of the colours that compare measures, N x N a pixel, 1..8 (default 2; fly, compare: 1)"},
    {"time", 0, V | R | F | C, GROUP_PICTURE, VALUE(option_time, "TIME"),
     "where the sun stands: UTC as YYYY-MM-DDTHH:MM[:SS]Z, or noon: always day (default)"},

    {"a", 0, C, GROUP_COMPARE, TEXT(side_a, "SIDE"),
     "what is judged: spherical (default) or another mode, reference, or an .exr that render wrote"},
    {"b", 0, C, GROUP_COMPARE, TEXT(side_b, "SIDE"), "what it is judged by (default reference)"},
    {"modes", 0, C, GROUP_COMPARE, TEXT(modes, "all|A,B,..."),
     "instead of --a: these modes, or all, side by side: errors, triangles, bytes, time, and along flights flicker"},
    {"views", 0, C, GROUP_COMPARE, TEXT(views, "FILE"),
     "with --modes: at each view of this JSON file, such as data/views/accuracy.json"},
    {"equal", 0, C, GROUP_COMPARE, VALUE(option_equal, "WHAT[=VALUE]"),
     "with --modes: choose each mode's size so that in each view all draw as many triangles, or have the same 99.9 % "
     "error: triangles, error, triangles=N or error=PX (default: as the first mode has by its defaults); of a flight "
     "by its middle frame"},
    {"repeats", 0, C, GROUP_COMPARE, INTEGER(repeats, 0, 1000, "N"),
     "with --modes: frames of a turning camera that are timed, of each mode in turn; 0: none (default 7)"},

    {"output", 'o', R | F | M | C | X, GROUP_OUTPUT, TEXT(output, "FILE"),
     "render: .png, or .exr with depth and position a pixel; fly: a pattern such as frames/%05d.png; "
     "import: the planet file; compare: the errors of each pixel to FILE.exr and FILE.png, of a flight's frames to "
     "FILE-00000.exr and so on; export: a folder"},
    {"csv", 0, C, GROUP_OUTPUT, TEXT(csv, "FILE"), "also write the table as CSV, a row a frame"},
    {"json", 0, C, GROUP_OUTPUT, TEXT(json_file, "FILE"), "also write the table as JSON"},
    {"picture", 0, C, GROUP_OUTPUT, TEXT(picture, "FILE.png"),
     "also write one picture with both sides, the error map, its scale and the table; of a flight the frame with the "
     "largest 99.9 % error"},
    {"half", 0, R, GROUP_OUTPUT, FLAG(half), "16-bit colour in EXR (default 32-bit; the other channels always are)"},
    {"stats", 0, R | F, GROUP_OUTPUT, TEXT(stats, "FILE"),
     "write what each frame cost, one line of JSON a frame"},
    {"contact-sheet", 0, F, GROUP_OUTPUT, TEXT(contact_sheet, "FILE"),
     "also write one PNG with small copies of evenly spaced frames"},
    {"contact-grid", 0, F, GROUP_OUTPUT, VALUE(option_grid, "NxM"), "columns and rows of the contact sheet (default 5x4)"},
    {"resume", 0, F, GROUP_OUTPUT, FLAG(resume), "keep frames of the right size that are there already"},

    {"wait", 0, R | F, GROUP_DATA, UNFLAG(no_wait), "render when all visible data is there (default)"},
    {"no-wait", 0, R | F, GROUP_DATA, FLAG(no_wait), "render with the data that is there"},
    {"timeout", 0, R | F | C, GROUP_DATA, NUMBER(timeout_s, 0, 86400, "S"),
     "give up waiting for a frame's data after S seconds, list what was missing and exit with 1 (default 60)"},
    {"threads", 0, V | R | F | M | C | X, GROUP_DATA, INTEGER(view_params.threads, 1, 256, "N"),
     "worker threads, 1..256 (default: one for each processor)"},
    {"cache-bytes", 0, V | R | F | C, GROUP_DATA, VALUE(option_bytes, "N[K|M|G]"),
     "memory for decoded tiles (default 256M)"},
    {"layer", 0, V | R | F, GROUP_DATA, VALUE(layers_add, "SOURCE[,...]"),
     "lay this over the planet, and later ones over it: a preset's name, a TileJSON file or URL, a URL with {z} {x} {y}, "
     "a raster or a planet file; then, if wanted, ,height or ,color and ,opacity=0..1"},
    {"tile-cache", 0, V | R | F, GROUP_DATA, TEXT(tile_cache, "FILE"),
     "where tiles of servers are kept, or none (default ${XDG_CACHE_HOME:-~/.cache}/perigee/tiles.db)"},
    {"tile-cache-bytes", 0, V | R | F, GROUP_DATA, VALUE(option_tile_bytes, "N[K|M|G]"),
     "how much is kept there; what was not used for longest goes first (default 1G)"},
    {"flat", 0, V | R | F | C, GROUP_METHOD, FLAG(planet_params.flat),
     "the map as a plane instead of a globe: a raster in its own projected reference system, anything else by longitude "
     "and latitude; --lat and --lon are still geographic, headings count from the map's north"},
    {"no-synthesis", 0, V | R | F | C, GROUP_DATA, FLAG(planet_params.no_synthesis),
     "the same as --synthesis none: only what the data says"},
    {"gpu-synthesis", 0, V | R | F | C, GROUP_DATA, FLAG(view_params.gpu_synthesis),
     "make levels below the data on the GPU from coarser ones, instead of tiles on the processor"},
    {"synthesis", 0, V | R | F | C, GROUP_DATA, VALUE(option_synthesis, "eroded|plain|none"),
     "detail below the data: ridges and gullies (default), plain noise, or none"},

    {"mode", 0, V | R | F, GROUP_METHOD, VALUE(option_mode, "MODE"),
     "spherical: rings (default); planar: nested squares of the map; grid: a screen grid thrown onto the planet; "
     "render, fly: or reference, a ray caster in double precision"},
    {"planar-n", 0, V | R | F | C, GROUP_METHOD, VALUE(option_planar_n, "N"),
     "planar: vertices across a square, 31, 63, 127, 255, 511 or 1023, less than --texels (default: one less)"},
    {"planar-form", 0, V | R | F | C, GROUP_METHOD, VALUE(option_planar_form, "FORM"),
     "planar: gpu: footprints, whole levels or none (default); 2004: rectangles cropped to data and frustum"},
    {"planar-triangles", 0, V | R | F | C, GROUP_METHOD, INTEGER(view_params.planar_triangles, 1000, 2000000000, "N"),
     "with --planar-form 2004: shrink the squares until no more than N triangles are in the frustum"},
    {"planar-heights", 0, V | R | F | C, GROUP_METHOD, VALUE(option_planar_heights, "FORM"),
     "planar: plain (default), or packed: whole metres and the coarser level's difference in one number"},
    {"planar-memory-free", 0, V | R | F | C, GROUP_METHOD, FLAG(view_params.planar_memory_free),
     "planar: keep no level that lies below all data; make them anew on the GPU in each frame"},
    {"planar-residuals", 0, V | R | F | C, GROUP_METHOD, FLAG(view_params.planar_residuals),
     "planar: heights in whole quanta, sent to the GPU as what they add to the next coarser level: half the bytes"},
    {"grid", 0, V | R | F | C, GROUP_METHOD, VALUE(option_screen_grid, "ROWSxCOLUMNS"),
     "vertices of --mode grid, 2..4096 each and at most 4194304 (default 360x480)"},
    {"grid-denser", 0, V | R | F | C, GROUP_METHOD, NUMBER(view_params.grid_denser, 0, 0.9, "SHARE"),
     "make that grid denser in the middle of the picture, 0..0.9 (default 0: the same everywhere)"},
    {"grid-farthest", 0, V | R | F | C, GROUP_METHOD, FLAG(view_params.grid_farthest),
     "that grid's heights by each vertex's farthest neighbour, as published, not by the mean of those along and across the ray: "
     "coarser far away"},
    {"zoom", 0, R | F | C, GROUP_METHOD, VALUE(option_zoom, "Z"),
     "of the reference: cast against heights of this zoom, 0..24, of the finest one stored, or auto: "
     "finer with nearness, by --zoom-error (default)"},
    {"zoom-error", 0, R | F | C, GROUP_METHOD, NUMBER(zoom_error_px, 1e-4, 100, "PX"),
     "with --zoom auto: how far the heights may be from endlessly refined ones, in pixels (default 0.05)"},
    {"heights", 0, R | F | C, GROUP_METHOD, VALUE(option_heights, "NAME"),
     "of the reference, between samples: bilinear (default) or bicubic, without creases"},
    {"quality", 0, V | R | F | C, GROUP_METHOD, VALUE(option_quality, "NAME"),
     "low, default, high or paper: 99.9 % of the pixels of 1280x960 at 90 degrees are within 2.7, 2, 0.9 or 6 pixels of the data"},
    {"error", 0, V | R | F | C, GROUP_METHOD, NUMBER(view_params.error_px, 0.01, 1000, "PX"),
     "instead: the cheapest setting that keeps this error; there are 2.7, 2, 1.4 and 0.9"},
    {"paper", 0, V | R | F | C, GROUP_METHOD, FLAG(paper), "the rings and windows of Clasen & Hege 2006; as --quality paper"},
    {"transform", 0, V | R | F | C, GROUP_METHOD, VALUE(option_transform, "NAME"),
     "stable (default), exact, approx or blend"},
    {"filter", 0, V | R | F | C, GROUP_METHOD, VALUE(option_filter, "NAME"),
     "height filter: sharp (default; --paper: emulated), emulated bilinear in full float, or hardware"},
    {"texcoord", 0, V | R | F | C, GROUP_METHOD, VALUE(option_texcoord, "WHERE"),
     "map coordinates by fragment (default) or vertex"},
    {"no-cull", 0, V | R | F | C, GROUP_METHOD, FLAG(view_params.no_cull), "draw every sector of every level in range"},
    {"levels", 0, V | R | F | C, GROUP_METHOD, VALUE(option_levels, "A-B"),
     "draw the levels A to B, 0..23, B at least 1 (default: by horizon and pixel size)"},
    {"azimuth-steps", 0, V | R | F | C, GROUP_METHOD, VALUE(option_azimuth_steps, "N"),
     "vertices around a ring, a multiple of 64, 64..4096 (default: by quality, 640)"},
    {"rings", 0, V | R | F | C, GROUP_METHOD, VALUE(option_rings, "M"),
     "rings a level, an even number, 2..512 (default: by quality, 64)"},
    {"texels", 0, V | R | F | C, GROUP_METHOD, VALUE(option_texels, "N"),
     "height samples across a level's ring, 128, 256, 512 or 1024 (default: by quality, 256)"},
    {"ring-spacing", 0, V | R | F | C, GROUP_METHOD, NUMBER(view_params.ring_spacing_px, -1, 1000, "PX"),
     "leave out rings and columns closer than this on the screen, -1: none (default: by quality)"},
    {"shader-dir", 0, V | R | F | C, GROUP_METHOD, TEXT(shader_dir, "DIR"), "read shaders from DIR instead of the built-in ones"},

    {"json", 0, N, GROUP_GENERAL, FLAG(json), "print JSON"},
    {"quiet", 'q', V | R | F | M | N | C | X, GROUP_GENERAL, FLAG(quiet), "no progress and no notes on standard error"},
    {"verbose", 'v', V | R | F | M | N | C | X, GROUP_GENERAL, FLAG(verbose), "more notes on standard error"},
    {"help", 'h', V | R | F | M | N | C | X, GROUP_GENERAL, FLAG(help), "this text"},
};
// clang-format on

const int option_count = sizeof option_table / sizeof option_table[0];
