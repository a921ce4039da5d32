// From any raster GDAL opens to a planet file: warp to the tile grid, pyramid by a filter circular in world space
// (Clasen & Hege 2006, 4.3). Main only; workers inside.
#ifndef PERIGEE_PLANET_IMPORT_H
#define PERIGEE_PLANET_IMPORT_H

#include "planet/planet_file.h"

typedef struct import_source {
    enum tile_layer layer;
    const char *path; // anything GDALOpen takes
} import_source;

typedef struct import_params {
    const import_source *sources; // later ones lie on top
    int source_count;
    const char *output;
    const char *name;        // NULL: from the output's file name
    const char *attribution; // NULL: none
    geo_ellipsoid ellipsoid; // zero: WGS84
    double bounds_deg[4];    // west, south, east, north; all zero: everything the sources cover
    int threads;             // 0: one for each processor
    bool resume;             // go on with the committed tiles of an interrupted import of the same sources
    bool force;              // replace an existing output
    // Called on the calling thread, a few times a second; return true to stop (what is committed stays). May be NULL.
    bool (*progress)(void *user, const char *stage, double done);
    void *user;
} import_params;

// Makes params->output by way of output.part, renamed when complete. ERR_CANCELLED leaves output.part for `resume`.
status import_run(const import_params *params);

typedef struct import_earth_params {
    const char *atlas_dir;   // NULL: where Debian's marble-qt-data puts its maps (/usr/share/marble/data/maps)
    const char *relief_csv;  // NULL: the installed atlas-relief-metres.csv
    const char *output;
    int threads;
    bool bathymetry;         // false: the sea connected to the ocean is laid at 0
    bool force, resume;
    bool (*progress)(void *user, const char *stage, double done);
    void *user;
} import_earth_params;

// The default Earth from the atlas: grey levels to metres, de-banded within each grey's interval, the sea laid flat,
// Blue Marble colour, city lights; then import_run.
status import_earth(const import_earth_params *params);

#endif
