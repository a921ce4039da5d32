// What the import's tests share: a folder of their own, small rasters written by GDAL, samples read
// back.
#ifndef PERIGEE_TESTS_IMPORT_COMMON_H
#define PERIGEE_TESTS_IMPORT_COMMON_H

#include "check.h"

#include <dirent.h>
#include <gdal.h>
#include <ogr_srs_api.h>
#include <stdbool.h>
#include <unistd.h>

#include "base/log.h"
#include "base/vec.h"
#include "planet/import.h"

#define RAD (M_PI / 180)

static char test_dir[256];
static char logged[4096];

static inline void keep_log(void *user, enum log_level level, const char *line)
{
    (void)user;
    size_t used = strlen(logged);
    if (level == LOG_ERROR) snprintf(logged + used, sizeof logged - used, "%s\n", line);
}

static inline int make_test_dir(void **state)
{
    (void)state;
    const char *base = getenv("TMPDIR");
    snprintf(test_dir, sizeof test_dir, "%s/perigee-import-XXXXXX", base ? base : P_tmpdir);
    GDALAllRegister();
    log_set_sink(keep_log, NULL);
    return mkdtemp(test_dir) ? 0 : -1;
}

static inline int remove_test_dir(void **state)
{
    (void)state;
    DIR *d = opendir(test_dir);
    for (struct dirent *e; d && (e = readdir(d));)
        if (strcmp(e->d_name, ".") && strcmp(e->d_name, "..")) unlinkat(dirfd(d), e->d_name, 0);
    if (d) closedir(d);
    return rmdir(test_dir);
}

// A path in the folder; four may be in use at a time.
static inline const char *in_dir(const char *name)
{
    static char paths[4][512];
    static int turn;
    char *path = paths[turn++ % 4];
    snprintf(path, sizeof paths[0], "%s/%s", test_dir, name);
    return path;
}

typedef struct raster_spec {
    const char *name;
    int width, height, bands;
    GDALDataType type;
    const char *crs;                               // anything OSRSetFromUserInput takes; NULL: none
    double transform[6];                           // all zero: none
    double (*value)(int band, double x, double y); // at sample centres in the CRS; band from 1
    const double *nodata;
    double scale, offset; // stored = (value - offset) / scale; scale 0: none
} raster_spec;

static inline GDALDatasetH create_raster(const raster_spec *s)
{
    GDALDatasetH d = GDALCreate(GDALGetDriverByName("GTiff"), in_dir(s->name), s->width, s->height,
                                s->bands, s->type, NULL);
    assert_non_null(d);
    if (s->transform[1] != 0) GDALSetGeoTransform(d, (double *)s->transform);
    if (s->crs) {
        OGRSpatialReferenceH srs = OSRNewSpatialReference(NULL);
        assert_int_equal(OSRSetFromUserInput(srs, s->crs), OGRERR_NONE);
        GDALSetSpatialRef(d, srs);
        OSRDestroySpatialReference(srs);
    }
    return d;
}

static inline void fill_band(GDALDatasetH d, const raster_spec *s, int b)
{
    GDALRasterBandH band = GDALGetRasterBand(d, b);
    if (s->nodata) GDALSetRasterNoDataValue(band, *s->nodata);
    if (s->scale != 0) {
        GDALSetRasterScale(band, s->scale);
        GDALSetRasterOffset(band, s->offset);
    }
    double *line = calloc((size_t)s->width, sizeof *line);
    for (int y = 0; y < s->height; y++) {
        for (int x = 0; x < s->width; x++) {
            double gx = s->transform[0] + (x + 0.5) * s->transform[1];
            double gy = s->transform[3] + (y + 0.5) * s->transform[5];
            line[x] = s->value(b, gx, gy);
            if (s->scale != 0) line[x] = (line[x] - s->offset) / s->scale;
        }
        assert_int_equal(
            GDALRasterIO(band, GF_Write, 0, y, s->width, 1, line, s->width, 1, GDT_Float64, 0, 0),
            CE_None);
    }
    free(line);
}

static inline void write_raster(const raster_spec *s)
{
    GDALDatasetH d = create_raster(s);
    for (int b = 1; b <= s->bands; b++) fill_band(d, s, b);
    GDALClose(d);
}

// Imports rasters of the folder, one layer each, into `output` there. Log lines go to `logged`.
static inline status import_files(const char *output, int count, const enum tile_layer *layers,
                                  const char *const *names)
{
    import_source sources[8];
    char paths[8][512], out[512];
    logged[0] = 0;
    for (int i = 0; i < count; i++) {
        snprintf(paths[i], sizeof paths[i], "%s", in_dir(names[i]));
        sources[i] = (import_source){.layer = layers[i], .path = paths[i]};
    }
    snprintf(out, sizeof out, "%s", in_dir(output));
    import_params p = {
        .sources = sources, .source_count = count, .output = out, .threads = 2, .force = true};
    return import_run(&p);
}

static inline status import_heights(const char *output, const char *name)
{
    return import_files(output, 1, (enum tile_layer[]){LAYER_HEIGHT}, &name);
}

static inline struct planet_file *open_planet(const char *name)
{
    struct planet_file *f;
    if (planet_file_open(in_dir(name), &f)) fail_msg("%s: %s", name, logged);
    return f;
}

// Tile and sample of a place, nearest sample.
static inline tile_id tile_at(enum tile_layer layer, int zoom, double lat, double lon, int *index)
{
    double step = grid_step_lat(zoom);
    int line = (int)floor((M_PI / 2 - lat) / step), row = line / TILE_SIZE;
    int column = (int)floor((lon + M_PI) / grid_step_lon(zoom, row));
    *index = line % TILE_SIZE * TILE_SIZE + column % TILE_SIZE;
    return (tile_id){layer, zoom, row, column / TILE_SIZE};
}

// Centre of a tile's sample.
static inline void sample_place(tile_id id, int index, double *lat, double *lon)
{
    double west, south, east, north;
    grid_bounds(id, &west, &south, &east, &north);
    *lat = grid_lat(id.zoom, (int64_t)id.row * TILE_SIZE + index / TILE_SIZE);
    *lon = west + (index % TILE_SIZE + 0.5) * grid_step_lon(id.zoom, id.row);
}

// The stored height of the sample nearest to a place (degrees); NaN also when its tile is not
// stored.
static inline double height_near(struct planet_file *f, int zoom, double lat_deg, double lon_deg)
{
    static float heights[TILE_SIZE * TILE_SIZE];
    int index;
    tile_id id = tile_at(LAYER_HEIGHT, zoom, lat_deg * RAD, lon_deg * RAD, &index);
    status s = planet_file_read_height(f, id, heights);
    if (s == ERR_NOT_FOUND) return NAN;
    assert_int_equal(s, OK);
    return heights[index];
}

// Of a raster to either side of 20 E: grey 90 and 240.
static inline double half_grey(int band, double lon, double lat)
{
    (void)band;
    (void)lat;
    return lon > 20 ? 240 : 90;
}

static inline double palette_index(int band, double lon, double lat)
{
    (void)band;
    (void)lat;
    return lon > 20 ? 7 : 3;
}

// A raster of bytes with a palette: (200, 100, 50) west of 20 E and (20, 60, 180) east of it.
static inline void write_palette(raster_spec s)
{
    s.bands = 1;
    s.value = palette_index;
    GDALDatasetH d = create_raster(&s);
    GDALColorTableH table = GDALCreateColorTable(GPI_RGB);
    GDALSetColorEntry(table, 3, &(GDALColorEntry){200, 100, 50, 255});
    GDALSetColorEntry(table, 7, &(GDALColorEntry){20, 60, 180, 255});
    GDALSetRasterColorTable(GDALGetRasterBand(d, 1), table);
    GDALDestroyColorTable(table);
    fill_band(d, &s, 1);
    GDALClose(d);
}

#endif
