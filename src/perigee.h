// Perigee's public C API: a planet-scale globe in the OpenGL context you already have.
//
//     perigee_planet *planet;  perigee_view *view;
//     perigee_planet_open("earth.planet", NULL, &planet);
//     perigee_view_create(planet, NULL, &view);            // an OpenGL 4.5 context is current
//     perigee_camera c = {.lat_deg = 45.6, .lon_deg = 10.7, .alt_m = 1000, .fov_deg = 60};
//     perigee_view_set_camera(view, &c);
//     perigee_view_render(view, 1280, 960);                // into the framebuffer bound now
//     perigee_view_destroy(&view);  perigee_planet_close(&planet);
//
// Angles in degrees, lengths in metres, times in seconds since 1970 (UTC). Every function that can
// fail returns 0 or a perigee_status; perigee_last_error() says in one line what was wrong. Views:
// the thread of their GL context only. Planets: any thread. Structs are zero-initialised by the
// caller; zero means the default stated.
#ifndef PERIGEE_H
#define PERIGEE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define PERIGEE_API __attribute__((visibility("default")))
#else
#define PERIGEE_API
#endif

typedef struct perigee_planet perigee_planet;
typedef struct perigee_view perigee_view;

// 0 is success; the numbers are those of base/status.h.
typedef int perigee_status;

PERIGEE_API const char *perigee_version(void);
PERIGEE_API const char *perigee_last_error(void);

enum perigee_layer_kind { PERIGEE_LAYER_ALL, PERIGEE_LAYER_HEIGHT, PERIGEE_LAYER_COLOR };

// A source over the ground: a planet file, a raster that GDAL reads, a tile source as TileJSON by
// path or URL (src/planet/source_spec.h), or a URL template with {z}, {x} and {y}.
typedef struct perigee_layer {
    const char *source;
    enum perigee_layer_kind kind; // only its heights, only its colour, or all it has
    double transparency;          // 0 opaque (default) to 1
} perigee_layer;

typedef struct perigee_planet_params {
    size_t cache_bytes;   // memory for decoded tiles; 0: 256 MiB
    bool no_synthesis;    // true: only what the data says
    bool plain_synthesis; // below the data noise without direction, not eroded ground
    bool
        flat; // the map as a plane, not wrapped onto the planet: of a raster in a projected
              // reference system that system's, else of longitude and latitude, true to scale along
              // the equator. Of a projected raster all latitudes and longitudes of this header are
              // places of the map (perigee_planet_map_place), and headings count from its north
    const perigee_layer *layers; // over the ground, lowest first; borrowed until the planet is open
    int layer_count;             // up to 15
    const char *tile_cache;      // file that keeps tiles of servers; NULL: none is kept
    uint64_t tile_cache_bytes;   // 0: 1 GiB
} perigee_planet_params;

typedef struct perigee_planet_info {
    char name[64];
    char attribution[512];
    double equatorial_radius_m, polar_radius_m; // of a plane both: metres a radian of the map
    double map_south_deg, map_north_deg, map_west_deg, map_east_deg; // of a plane: where its map
                                                                     // ends; all 0: a globe
    bool map_projected; // of a plane: the map is a projected raster's
    double height_min_m, height_max_m;
    int height_zoom, color_zoom, night_zoom; // finest zoom stored, -1: none
} perigee_planet_info;

// path: the ground, anything that a layer may be. Where it has nothing the ground is bare and lies
// on the ellipsoid.
PERIGEE_API perigee_status perigee_planet_open(const char *path,
                                               const perigee_planet_params *params,
                                               perigee_planet **out);
PERIGEE_API void perigee_planet_close(perigee_planet **planet); // after its views
// A place by its geographic latitude and longitude as a place of the planet's map, in place, and
// places of the map back (NaN where there is no such). They differ over projected rasters alone.
PERIGEE_API perigee_status perigee_planet_map_place(perigee_planet *planet, double *lat_deg,
                                                    double *lon_deg);
PERIGEE_API void perigee_planet_geographic(perigee_planet *planet, int count, double *lat_deg,
                                           double *lon_deg);
// The same places as northing and easting, in place: coordinates of the raster's reference system
// in its own units. Without a projected raster nothing is changed.
PERIGEE_API void perigee_planet_map_coordinates(const perigee_planet *planet, int count,
                                                double *lat_deg, double *lon_deg);
PERIGEE_API void perigee_planet_get_info(const perigee_planet *planet, perigee_planet_info *out);
// Terrain height above the ellipsoid, as rendered at the finest level. Reads tiles: may wait for
// the disk.
PERIGEE_API perigee_status perigee_planet_height(perigee_planet *planet, double lat_deg,
                                                 double lon_deg, double *height_m);
// The same without waiting, from tiles that are in memory: NaN when there is none. Returns whether
// they are the finest, so that the height is that of perigee_planet_height.
PERIGEE_API bool perigee_planet_height_now(perigee_planet *planet, double lat_deg, double lon_deg,
                                           double *height_m);
// Ends the waiting of other threads in perigee_planet_height, now and for good: for who has to wait
// for them and does not want to wait for a server. They get the code for cancelled.
PERIGEE_API void perigee_planet_stop_waiting(perigee_planet *planet);

// How vertices are placed. Data, streaming, shading and measures are the same in all modes.
enum perigee_mode {
    PERIGEE_MODE_SPHERICAL, // concentric rings about the viewer (Clasen & Hege 2006); default
    PERIGEE_MODE_PLANAR,    // nested squares of the map of longitude and latitude, wrapped onto the
                            // planet: geometry clipmaps (Losasso & Hoppe 2004; Asirvatham & Hoppe
                            // 2005). At odds with the poles
    PERIGEE_MODE_GRID,      // a grid on the screen, thrown onto the planet (Livny et al. 2008)
};

// As on the command line; NULL for a number that is no mode. Modes count from 0 without a gap.
PERIGEE_API const char *perigee_mode_name(enum perigee_mode mode);

enum perigee_transform {
    PERIGEE_TRANSFORM_STABLE, // free of cancellation (default)
    PERIGEE_TRANSFORM_EXACT,  // Clasen & Hege 2006, eq. 9, 12
    PERIGEE_TRANSFORM_APPROX, // eq. 11, 14
    PERIGEE_TRANSFORM_BLEND,  // exact far out, approximate near, blended over two levels
};

// What a vertex's height is made from.
enum perigee_filter {
    PERIGEE_FILTER_BY_QUALITY, // sharp; for PERIGEE_QUALITY_PAPER emulated
    PERIGEE_FILTER_SHARP,      // 4 x 4 samples, which gives back what means and straight lines take
                               // (of the rings; other modes: emulated)
    PERIGEE_FILTER_EMULATED,   // bilinear, weights in full float
    PERIGEE_FILTER_HARDWARE,   // the GPU's own bilinear filter (8-bit weights)
};

// How fine the mesh and its heights are. Error: distance of what is drawn from the finest data's
// surface on a screen of 1280 x 960 pixels and 90 degrees, kept by 99.9 % of the pixels in all
// views measured but telephotos along the ground (tests/ACCURACY.md, 3).
enum perigee_quality {
    PERIGEE_QUALITY_DEFAULT, // 2 pixels
    PERIGEE_QUALITY_LOW,     // 2.7 pixels
    PERIGEE_QUALITY_HIGH,    // 0.9 pixels
    PERIGEE_QUALITY_PAPER,   // 6 pixels:   n = 512, m = 20, N = 128 (Clasen & Hege 2006)
};

// How the planar mode draws its squares.
enum perigee_planar_form {
    PERIGEE_PLANAR_GPU,  // instances of footprints, whole levels or none (2005; default)
    PERIGEE_PLANAR_2004, // rectangles cropped to the data and to the frustum
};

typedef struct perigee_view_params {
    enum perigee_mode mode;
    int threads; // workers that read and resample, up to 256; 0: one for each processor
    enum perigee_quality quality;
    double error_px;        // > 0: instead of `quality`, the cheapest that keeps this error
    int azimuth_steps;      // n; 0: by quality. A multiple of 64
    int rings_per_level;    // m; 0: by quality
    int texels;             // N, height samples across a level's ring: 128, 256, 512 or 1024;
                            // 0: by quality
    double ring_spacing_px; // rings and columns closer on the screen are left out; 0: by quality,
                            // < 0: none is
    int planar_n;           // vertices across a square of the planar mode: 31, 63, 127, 255, 511 or
                            // 1023, less than texels; 0: texels - 1
    enum perigee_planar_form planar_form;
    uint32_t planar_triangles; // of the form of 2004: shrink its regions until no more are in the
                               // frustum, as far as can be; 0: no bound
    bool planar_packed;      // true: its heights in one number, whole metres (2005, 2.4.1); coarse
    bool planar_memory_free; // true: levels below all data are not kept but made anew on the GPU in
                             // each frame (2005, 2.6.3). Of the form of 2005; levels that cannot be
                             // made so (gpu_synthesis, which it includes) are left out
    bool planar_residuals;   // true: heights are whole quanta of 1/2400 of their distance, at least
                             // 2^-10 m, and what data add to the coarser level is added to it on
                             // the GPU (2005, 2.4): half the bytes of heights to upload
    int levels;              // 0: 24, the most (levels 0-23: the finest ring is 2.4 m wide)
    int first_level;         // coarsest level drawn; 0: by the horizon
    int last_level;          // finest level drawn; 0: by the pixel size
    enum perigee_transform transform;
    int grid_rows, grid_columns; // vertices of PERIGEE_MODE_GRID, 2 to 4096 each and up to 4 Mi in
                                 // all; 0: 360, 480
    double grid_denser; // how much denser that grid is in the middle of the picture: 0 to 0.9
    bool grid_farthest; // true: its heights as coarse as a vertex's farthest neighbour (Livny et
                        // al. 2008); else as the geometric mean of those along and across
    enum perigee_filter filter;
    bool texcoord_vertex;  // true: map coordinates interpolated from the vertices, as in the paper
    bool seam_uncorrected; // true: and the seam's second copy as the first; to show what it cures
    bool no_cull;          // true: draw every sector of every level in range
    bool no_antialias;
    bool no_sky_glow;
    bool gpu_synthesis; // levels below the data are made on the GPU, not from tiles
    bool identify;      // true: keeps which triangle drew each pixel (perigee_view_read_triangles)
    size_t upload_bytes_frame;   // bytes uploaded a frame at most; 0: 4 MiB
    size_t update_samples_frame; // samples of heights, and as many of colour, renewed a frame at
                                 // most; 0: as many as one level has (the n^2 of Losasso & Hoppe)
} perigee_view_params;

// Makes the mesh of params->mode as near to `size` times as fine as it can be made: so many times
// the vertices across as the default has, with heights as fine as that needs; 1: the default's.
// Sets the mode's own parameters only, and texels. Modes that are cut to a number of triangles need
// to know how many the default draws of the view in question, others do not mind (0). false: the
// mode has one size, or `size` is not positive.
PERIGEE_API bool perigee_view_params_resize(perigee_view_params *params, double size,
                                            uint64_t triangles);

typedef struct perigee_camera {
    double lat_deg, lon_deg, alt_m; // altitude above the ellipsoid
    double heading_deg;             // clockwise from north
    double pitch_deg;               // 0 the horizon, -90 straight down
    double roll_deg;
    double fov_deg; // vertical; 0: 60
} perigee_camera;

typedef struct perigee_stats {
    uint64_t frames;
    // of the last frame
    uint32_t first_level, last_level;
    uint64_t triangles_total; // of all sectors of the levels in range, before culling
    uint64_t triangles_drawn;
    uint64_t vertices_placed;
    uint64_t bytes_uploaded;
    uint64_t samples_updated;       // of heights and of colour
    uint32_t height_levels_yielded; // held back by the budget of samples, or because the camera is
    uint32_t color_levels_yielded;  // too fast for them to come in time; finest first, as bits
    uint64_t draws;
    double gpu_ms, cpu_ms; // gpu_ms < 0 while unknown
    // since creation
    uint64_t total_bytes_uploaded, total_vertices_placed, tiles_decoded, tiles_synthesised,
        tiles_corrupt;
    size_t gpu_bytes;         // textures and geometry, fixed at creation
    size_t gpu_bytes_targets; // frame-sized buffers
    bool map_edge;            // of the last frame, planar mode: a pole is in sight, where wrapping
                              // the map fails and ground is drawn with the coarsest levels
    bool needs_redraw; // data or a fade is still under way, or data that could not be had yet
} perigee_stats;

PERIGEE_API perigee_status perigee_view_create(perigee_planet *planet,
                                               const perigee_view_params *params,
                                               perigee_view **out);
PERIGEE_API void perigee_view_destroy(perigee_view **view);

PERIGEE_API perigee_status perigee_view_set_camera(perigee_view *view,
                                                   const perigee_camera *camera);
// Puts the sun where it stands at a time. Default: always day.
PERIGEE_API perigee_status perigee_view_set_time(perigee_view *view, double unix_time_s);
// Puts the sun in a direction from the planet's centre (ECEF, of any finite length but 0).
PERIGEE_API perigee_status perigee_view_set_sun(perigee_view *view, const double direction[3]);
// Back to always day: the sun stands 30 to 90 degrees high over the camera, wherever that is.
PERIGEE_API void perigee_view_set_time_noon(perigee_view *view);

// Renders one frame into the framebuffer bound now, viewport (0, 0, width, height). Never waits for
// data.
PERIGEE_API perigee_status perigee_view_render(perigee_view *view, int width, int height);

// Streams until every visible level is complete or timeout_s has passed: 0 or the code for a
// timeout. For data that stand in for what could not be had it waits up to 20 s more, once in an
// outage.
PERIGEE_API perigee_status perigee_view_wait(perigee_view *view, int width, int height,
                                             double timeout_s);
// What is missing now, one "layer level: strips" entry a line, into text (cut to size). Returns the
// number of entries.
PERIGEE_API int perigee_view_missing(const perigee_view *view, char *text, size_t size);

PERIGEE_API void perigee_view_get_stats(const perigee_view *view, perigee_stats *out);

// Per-pixel truth of the last frame, top row first, each plane width * height floats; NULL planes
// are skipped. Sky pixels are NaN (level: -1). Waits for the GPU.
typedef struct perigee_planes {
    float *r, *g, *b; // linear light
    float *z_m;       // distance along the view axis
    float *height_m;  // above the ellipsoid
    double *lat_deg, *lon_deg;
    float *level; // continuous level of detail
} perigee_planes;
PERIGEE_API perigee_status perigee_view_read_planes(perigee_view *view, perigee_planes *planes);

// Which triangle of the mesh drew each pixel of the last frame, for a view created with `identify`
// (else the code for an impossible argument). Planes: width * height, top row first; NULL planes
// are skipped. Pixels of one triangle have one number, and no other pixel has it; it says nothing
// beyond the frame. Waits for the GPU.
typedef struct perigee_triangles {
    uint32_t *triangle; // 0: sky
    int *level;         // of the triangle's ring; last_level + 1: inside the finest ring; -1: sky
    int *sector;        // of azimuth, 0 to 31 clockwise from north; planar: the block, 0 to 15, or
                        // another footprint, from 16 on; -1: sky
    // results
    uint64_t ground_pixels; // pixels that are not sky
    uint64_t visible;       // triangles that own a pixel
} perigee_triangles;
PERIGEE_API perigee_status perigee_view_read_triangles(perigee_view *view,
                                                       perigee_triangles *triangles);

// Renders off screen at any size, supersampled `samples` x `samples` times (1-8), into 8-bit sRGB
// RGB, top row first.
PERIGEE_API perigee_status perigee_view_render_image(perigee_view *view, int width, int height,
                                                     int samples, uint8_t *rgb);

// Geodetic point under a pixel of the last frame (0, 0 the top left corner); the code for not-found
// on sky.
PERIGEE_API perigee_status perigee_view_pick(perigee_view *view, double x_px, double y_px,
                                             double *lat_deg, double *lon_deg, double *height_m);

#ifdef __cplusplus
}
#endif

#endif
