// From any raster GDAL opens to a planet file: warp to the tile grid, pyramid by a filter circular
// in world space (Clasen & Hege 2006, 4.3). Main only; workers inside.
//
// Finest zoom of a source: the coarsest whose step of latitude is at most 1.1 of the source's own
// sample distance in that direction, so that no detail is lost; for a source that is not in
// longitude and latitude the median over the raster of the square root of a sample's area on the
// ground stands for it. (2' on 1.32' of zoom 5, 8' on 5.27' of zoom 3.) Heights are metres above
// the planet's ellipsoid; those above a vertical datum that the source declares, or that its
// `vertical` says, are brought there (import_vertical.h); band units of feet, kilometres and the
// like are converted. Colour is bands 1 to 3 (RGB, a palette or one grey; 8 or 16 bits), night one
// band or the luminance of three. No data: the band's no-data value, mask or alpha, NaN and
// infinity. Two imports of the same sources and settings give the same tiles, whatever the threads
// and interruptions.
#ifndef PERIGEE_PLANET_IMPORT_H
#define PERIGEE_PLANET_IMPORT_H

#include "planet/import_team.h"
#include "planet/planet_file.h"
#include "planet/quantum.h"

// Seams of an import, see import_params.
enum { FEATHER_ROWS = 8 }; // usual width of edges
#define FEATHER_AUTO   (-1.0)
#define FEATHER_MOST_M 1e6

typedef struct import_source {
    enum tile_layer layer;
    // Anything GDAL opens; or, when no file has that name, a pattern of file names as in glob(7),
    // whose matches are taken in the order of their names.
    const char *path;
    const char *vertical; // what heights stand above, as in import_vertical.h; NULL: as declared
    int priority;         // sources of a higher one lie on top of all of a lower one
} import_source;

// What an import did, over all processes.
typedef struct import_report {
    uint64_t tiles;   // in the finished file
    uint64_t made;    // by this run; the others were there before
    uint64_t uniform; // of `made`: one value throughout
    uint64_t samples; // of `made`, all channels of a pixel counting as one
    uint64_t bytes;   // of the finished file
    double seconds;
    int threads; // workers of all processes
} import_report;

typedef struct import_params {
    // On top lies the highest priority, then the finest zoom, then the last given.
    const import_source *sources;
    int source_count;
    const char *output;
    const char *name;        // NULL: from the output's file name
    const char *attribution; // NULL: none
    geo_ellipsoid ellipsoid; // zero: WGS84
    // Width over which every edge of the upper source is blended, of its border, of its holes, and
    // over others of its own zoom: in its rows, up to 255; 0: none.
    int feather_rows;
    // Width of the seam along its outer border, in metres, towards small sources less
    // (import_outline.h); FEATHER_AUTO: as wide as a sample of what lies below; 0: feather_rows of
    // its own zoom.
    double feather_m;
    // Heights are stored as multiples of the greatest power of two up to this many metres (2^-12 to
    // 2^8), at most half of it off; QUANTUM_AUTO: of one for each zoom; 0: as the floats they are,
    // at many times the size.
    double quantum;
    // > 0: heights are stored at most this many metres off, as codec_bounded.h (`quantum` is not
    // looked at); checked for every tile.
    double max_error;
    double bounds_deg[4]; // west, south, east, north; all zero: everything the sources cover
    int threads;          // 0: one for each processor
    size_t kept_bytes; // bound of the tiles just made that are kept for the zoom above; 0: 512 MiB
    bool resume; // go on with the committed tiles of an interrupted import of the same sources
    bool force;  // replace an existing output
    // Put the sources on top of the finished planet at `output` (where they are not coarser than
    // what it has), whose ellipsoid, quantum and greatest error stay, and whose name and
    // attribution do unless given here. Only the tiles that the sources touch, in each zoom, are
    // made anew, and those next to them that the filter reaches; the file is replaced as a whole.
    // With a greatest error: what is new is as far off at most from what is made of the sources
    // and of the planet as it is stored; the planet's own tiles come no farther off, but
    // for samples at the border of finer data, up to twice as far.
    bool add;
    const import_team *team; // processes that share the work; NULL: alone
    import_report *report;   // filled when the import is complete, of rank 0; may be NULL
    // Called on the calling thread, a few times a second; return true to stop (what is committed
    // stays). May be NULL.
    bool (*progress)(void *user, const char *stage, double done);
    void *user;
} import_params;

// Makes params->output: tiles go to output.part (other processes: output.part.1, ...), which can be
// resumed after any kind of end; when all are there they are gathered into output.joining, which
// takes the output's name. The same sources and settings give the same file, byte by byte, whatever
// the threads, processes and interruptions. Disk: twice the planet. ERR_CANCELLED leaves
// output.part for `resume`.
status import_run(const import_params *params);

// What import_run would have to do, measured on a few tiles of each layer. Writes nothing.
typedef struct import_estimate {
    uint64_t tiles, samples;
    double bytes;        // of the finished file
    double core_seconds; // of one thread, reading included
} import_estimate;

status import_estimate_run(const import_params *params, import_estimate *out);

typedef struct import_earth_params {
    const char *atlas_dir;  // NULL: where Debian's marble-qt-data puts its maps
                            // (/usr/share/marble/data/maps)
    const char *relief_csv; // NULL: the installed atlas-relief-metres.csv
    const char *output;
    int threads;
    bool bathymetry; // false: the sea connected to the ocean is laid at 0
    bool force, resume;
    bool (*progress)(void *user, const char *stage, double done);
    void *user;
} import_earth_params;

// The default Earth from the atlas: grey levels to metres, de-banded within each grey's interval
// (atlas.h), the sea laid flat and no land lower than the Dead Sea's shore (unless `bathymetry`),
// Blue Marble colour, city lights; then the import proper. Its heights are above mean sea level and
// are taken as heights above the ellipsoid: the geoid's -107 to 85 m are left out, so that the sea
// is at 0 everywhere. How far it is from the truth: tests/planet/test_import_earth.c, against
// data/spot-heights.csv.
status import_earth(const import_earth_params *params);

#endif
