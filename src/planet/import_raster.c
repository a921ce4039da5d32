#include "planet/import_raster.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <float.h>
#include <gdal.h>
#include <gdal_utils.h>
#include <ogr_srs_api.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/import_light.h"
#include "planet/import_vertical.h"
#include "planet/import_warp.h"

enum { MAX_BANDS = 3, MAX_CHAIN = 3 };

// A planet file takes heights up to 1e7 m; half of that leaves room for the filters' overshoot.
#define HEIGHT_MOST_M 5e6

struct raster {
    const char *path;
    enum tile_layer layer;
    raster_grid grid;
    const float *memory;
    GDALDatasetH chain[MAX_CHAIN]; // the file, then what was derived from it; the last one is read
    int chain_length;
    int bands[MAX_BANDS], band_count;
    GDALRasterBandH mask; // NULL: none
    bool has_nodata[MAX_BANDS];
    double nodata[MAX_BANDS];
    double scale, offset;      // metres = sample * scale + offset; pixels: to codes of 0 to 255
    struct vertical *vertical; // NULL: heights are above the ellipsoid
    float height_most;         // heights further from the ellipsoid are no data
    bool south_up;
    char error[512]; // of the last read that failed
};

static void register_drivers(void)
{
    GDALAllRegister();
}

static GDALDatasetH last(const struct raster *r)
{
    return r->chain[r->chain_length - 1];
}

int raster_zoom_of_step(double step)
{
    int zoom = 0;
    while (zoom < GRID_MAX_ZOOM && grid_step_lat(zoom) > 1.1 * step) zoom++;
    return zoom;
}

static status check_samples(GDALDatasetH d, const char *path)
{
    int width = GDALGetRasterXSize(d), height = GDALGetRasterYSize(d);
    if (GDALGetRasterCount(d) == 0) {
        bool inner = CSLCount(GDALGetMetadata(d, "SUBDATASETS")) > 0;
        log_error("%s: holds no raster band%s", path, inner ? "; name one of its subdatasets" : "");
        return ERR_FORMAT;
    }
    if (width >= 2 && height >= 2) return OK;
    log_error("%s: has %d x %d samples, at least 2 x 2 are needed", path, width, height);
    return ERR_FORMAT;
}

static status check_georeference(GDALDatasetH d, const char *path)
{
    double g[6];
    bool placed = GDALGetGeoTransform(d, g) == CE_None;
    if (placed)
        for (int i = 0; i < 6; i++) placed = placed && isfinite(g[i]);
    if (placed && g[1] * g[5] - g[2] * g[4] == 0) placed = false;
    if (!placed && GDALGetGCPCount(d) < 3) {
        log_error("%s: has no georeference (neither a geotransform nor ground control points)",
                  path);
        return ERR_ARGUMENT;
    }
    if (GDALGetSpatialRef(d) || GDALGetGCPSpatialRef(d)) return OK;
    log_error("%s: has no coordinate reference system", path);
    return ERR_ARGUMENT;
}

// Bands that carry the layer, alpha left out; ERR_FORMAT when they cannot.
static status choose_bands(struct raster *r)
{
    GDALDatasetH d = r->chain[0];
    int usable = 0, chosen[MAX_BANDS] = {0};
    for (int i = 1; i <= GDALGetRasterCount(d); i++) {
        if (GDALGetRasterColorInterpretation(GDALGetRasterBand(d, i)) == GCI_AlphaBand) continue;
        if (usable < MAX_BANDS) chosen[usable] = i;
        usable++;
    }
    if (!usable) {
        log_error("%s: holds nothing but an alpha band", r->path);
        return ERR_FORMAT;
    }
    r->band_count = r->layer != LAYER_HEIGHT && usable >= 3 ? 3 : 1;
    memcpy(r->bands, chosen, sizeof chosen);
    GDALDataType type = GDALGetRasterDataType(GDALGetRasterBand(d, chosen[0]));
    bool fits = r->layer == LAYER_HEIGHT ? !GDALDataTypeIsComplex(type)
                                         : type == GDT_Byte || type == GDT_UInt16;
    if (fits) return OK;
    log_error("%s: samples of type %s cannot be %s", r->path, GDALGetDataTypeName(type),
              r->layer == LAYER_HEIGHT ? "heights" : "colours (8 or 16 bits unsigned can)");
    return ERR_FORMAT;
}

static double metres_per_unit(const char *unit)
{
    static const struct {
        const char *name;
        double metres;
    } units[] = {{"ft", 0.3048},
                 {"feet", 0.3048},
                 {"foot", 0.3048},
                 {"us-ft", 1200.0 / 3937},
                 {"US survey foot", 1200.0 / 3937},
                 {"km", 1000},
                 {"kilometre", 1000},
                 {"cm", 0.01},
                 {"dm", 0.1}};
    for (size_t i = 0; i < sizeof units / sizeof *units; i++)
        if (!strcasecmp(unit, units[i].name)) return units[i].metres;
    return 1;
}

static void read_scaling(struct raster *r)
{
    GDALRasterBandH band = GDALGetRasterBand(r->chain[0], r->bands[0]);
    r->scale = 1;
    if (r->layer != LAYER_HEIGHT) {
        if (GDALGetRasterDataType(band) == GDT_UInt16) r->scale = 255.0 / 65535;
        return;
    }
    double unit = metres_per_unit(GDALGetRasterUnitType(band));
    int has = 0;
    double scale = GDALGetRasterScale(band, &has);
    if (has && isfinite(scale) && scale != 0) r->scale = scale;
    double offset = GDALGetRasterOffset(band, &has);
    if (has && isfinite(offset)) r->offset = offset;
    r->scale *= unit;
    r->offset *= unit;
}

static void derive(struct raster *r, GDALDatasetH d)
{
    r->chain[r->chain_length++] = d;
}

// A palette becomes red, green, blue and alpha bands, because its indices cannot be averaged.
static status expand_palette(struct raster *r)
{
    GDALRasterBandH band = GDALGetRasterBand(r->chain[0], 1);
    if (r->layer == LAYER_HEIGHT || !GDALGetRasterColorTable(band)) return OK;
    char **list = NULL;
    list = CSLAddString(list, "-of");
    list = CSLAddString(list, "VRT");
    list = CSLAddString(list, "-expand");
    list = CSLAddString(list, "rgba");
    GDALTranslateOptions *options = GDALTranslateOptionsNew(list, NULL);
    GDALDatasetH expanded = options ? GDALTranslate("", r->chain[0], options, NULL) : NULL;
    GDALTranslateOptionsFree(options);
    CSLDestroy(list);
    if (!expanded) {
        log_error("%s: its palette cannot be expanded: %s", r->path, CPLGetLastErrorMsg());
        return ERR_FORMAT;
    }
    derive(r, expanded);
    r->band_count = 3;
    for (int i = 0; i < 3; i++) r->bands[i] = i + 1;
    return OK;
}

// How samples without data are marked in the dataset that is read.
static void find_mask(struct raster *r)
{
    for (int i = 0; i < r->band_count; i++) {
        GDALRasterBandH band = GDALGetRasterBand(last(r), r->bands[i]);
        int has = 0;
        r->nodata[i] = GDALGetRasterNoDataValue(band, &has);
        r->has_nodata[i] = has && isfinite(r->nodata[i]);
    }
    GDALRasterBandH band = GDALGetRasterBand(last(r), r->bands[0]);
    int flags = GDALGetMaskFlags(band);
    if (!(flags & (GMF_ALL_VALID | GMF_NODATA))) r->mask = GDALGetMaskBand(band);
}

static status place_grid(struct raster *r)
{
    double g[6];
    GDALGetGeoTransform(last(r), g);
    raster_grid *grid = &r->grid;
    const double rad = M_PI / 180;
    r->south_up = g[5] > 0;
    grid->dlon = g[1] * rad;
    grid->dlat = fabs(g[5]) * rad;
    grid->west = geo_wrap_lon(g[0] * rad);
    grid->north = (r->south_up ? g[3] + g[5] * grid->height : g[3]) * rad;
    double south = grid->north - grid->height * grid->dlat;
    if (grid->north <= M_PI / 2 + 2 * grid->dlat && south >= -M_PI / 2 - 2 * grid->dlat &&
        grid->width * grid->dlon <= 2 * M_PI + 2 * grid->dlon)
        return OK;
    log_error("%s: its extent (%g to %g degrees of latitude, %g of longitude) is not on the globe",
              r->path, south / rad, grid->north / rad, grid->width * grid->dlon / rad);
    return ERR_ARGUMENT;
}

static void finish_grid(raster_grid *g)
{
    // A whole number of columns around the globe closes the circle; a column that repeats the first
    // is left out.
    double around = round(2 * M_PI / g->dlon);
    if (fabs(around * g->dlon - 2 * M_PI) < 0.01 * g->dlon && g->width >= around) {
        g->full_circle = true;
        g->width = (int)around;
        g->dlon = 2 * M_PI / around;
    }
    g->south = g->north - g->height * g->dlat;
    g->east = g->west + g->width * g->dlon;
    g->zoom = raster_zoom_of_step(g->dlat);
}

static status open_file(struct raster *r, const import_input *input, geo_ellipsoid ellipsoid)
{
    bool global = input->global;
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, register_drivers);
    GDALDatasetH file = GDALOpenEx(
        r->path, GDAL_OF_RASTER | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR, NULL, NULL, NULL);
    if (!file) {
        log_error("%s: cannot be opened as a raster: %s", r->path, CPLGetLastErrorMsg());
        return access(r->path, F_OK) ? ERR_NOT_FOUND : ERR_FORMAT;
    }
    derive(r, file);
    status s = check_samples(file, r->path);
    if (!s && !global) s = check_georeference(file, r->path);
    if (!s) s = choose_bands(r);
    if (!s) read_scaling(r);
    if (!s && r->layer == LAYER_HEIGHT)
        s = vertical_open(file, r->path, input->source.vertical, ellipsoid, &r->vertical);
    if (!s) s = expand_palette(r);
    if (!s && !global && !warp_is_geographic(last(r), ellipsoid)) {
        void *warped;
        s = warp_to_geographic(last(r), r->path, ellipsoid, &warped, &r->grid.outline);
        if (!s) derive(r, warped);
    }
    if (s) return s;
    find_mask(r);
    r->grid.width = GDALGetRasterXSize(last(r));
    r->grid.height = GDALGetRasterYSize(last(r));
    return global ? OK : place_grid(r);
}

status raster_open(const import_input *input, geo_ellipsoid ellipsoid, struct raster **out)
{
    struct raster *r = NEW(struct raster);
    r->path = input->source.path;
    r->layer = input->source.layer;
    r->height_most = (float)fmin(HEIGHT_MOST_M, 0.5 * fmin(ellipsoid.a, ellipsoid.b));
    r->grid.channels = r->layer == LAYER_COLOR ? 3 : 1;
    r->grid.read_planes = r->layer == LAYER_HEIGHT ? 1 : 3;
    status s = OK;
    if (input->memory) {
        r->memory = input->memory;
        r->grid.width = input->width;
        r->grid.height = input->height;
    } else {
        CPLPushErrorHandler(CPLQuietErrorHandler);
        s = open_file(r, input, ellipsoid);
        CPLPopErrorHandler();
    }
    if (!s && (input->memory || input->global)) {
        r->grid.west = -M_PI;
        r->grid.north = M_PI / 2;
        r->grid.dlon = 2 * M_PI / r->grid.width;
        r->grid.dlat = M_PI / r->grid.height;
    }
    if (!s) finish_grid(&r->grid);
    if (s) raster_close(&r);
    *out = r;
    return s;
}

void raster_close(struct raster **raster)
{
    struct raster *r = *raster;
    if (!r) return;
    vertical_close(&r->vertical);
    while (r->chain_length) GDALClose(r->chain[--r->chain_length]);
    free(r);
    *raster = NULL;
}

const raster_grid *raster_get_grid(const struct raster *r)
{
    return &r->grid;
}

static void flip_rows(float *plane, int cols, int rows)
{
    for (int a = 0, b = rows - 1; a < b; a++, b--)
        for (int i = 0; i < cols; i++) {
            float v = plane[(size_t)a * (size_t)cols + (size_t)i];
            plane[(size_t)a * (size_t)cols + (size_t)i] =
                plane[(size_t)b * (size_t)cols + (size_t)i];
            plane[(size_t)b * (size_t)cols + (size_t)i] = v;
        }
}

static void erase_nodata(const struct raster *r, float *planes, size_t count)
{
    // In pixels only a sample that is no-data in every band is.
    for (int b = 0; b < r->band_count; b++)
        if (!r->has_nodata[b]) return;
    for (size_t i = 0; i < count; i++) {
        bool empty = true;
        for (int b = 0; b < r->band_count; b++)
            empty = empty && planes[(size_t)b * count + i] == (float)r->nodata[b];
        for (int b = 0; empty && b < r->band_count; b++) planes[(size_t)b * count + i] = NAN;
    }
}

static bool erase_masked(struct raster *r, int col, int row, int cols, int rows, float *planes)
{
    size_t count = (size_t)cols * (size_t)rows;
    unsigned char *mask = malloc(count);
    bool read = mask && GDALRasterIO(r->mask, GF_Read, col, row, cols, rows, mask, cols, rows,
                                     GDT_Byte, 0, 0) == CE_None;
    for (size_t i = 0; read && i < count; i++)
        for (int b = 0; mask[i] < 128 && b < r->band_count; b++)
            planes[(size_t)b * count + i] = NAN;
    free(mask);
    return read;
}

// Samples as the layer means them: metres, or linear light.
static void convert(const struct raster *r, float *planes, size_t count)
{
    size_t all = count * (size_t)r->band_count;
    float scale = (float)r->scale, offset = (float)r->offset;
    float most = r->layer == LAYER_HEIGHT ? r->height_most : FLT_MAX;
    for (size_t i = 0; i < all; i++) {
        float v = planes[i] * scale + offset;
        planes[i] = fabsf(v) <= most ? v : NAN;
    }
    if (r->layer == LAYER_HEIGHT) return;
    light_decode(planes, all);
    if (r->layer == LAYER_COLOR && r->band_count == 1)
        for (int c = 1; c < 3; c++)
            memcpy(planes + (size_t)c * count, planes, count * sizeof *planes);
    if (r->layer == LAYER_NIGHT && r->band_count == 3)
        for (size_t i = 0; i < count; i++)
            planes[i] =
                0.2126f * planes[i] + 0.7152f * planes[count + i] + 0.0722f * planes[2 * count + i];
}

static status read_file(struct raster *r, int col, int row, int cols, int rows, float *planes)
{
    int from = r->south_up ? GDALGetRasterYSize(last(r)) - row - rows : row;
    size_t count = (size_t)cols * (size_t)rows;
    CPLPushErrorHandler(CPLQuietErrorHandler);
    bool read = GDALDatasetRasterIO(last(r), GF_Read, col, from, cols, rows, planes, cols, rows,
                                    GDT_Float32, r->band_count, r->bands, 0, 0, 0) == CE_None;
    if (read) erase_nodata(r, planes, count);
    if (read && r->mask) read = erase_masked(r, col, from, cols, rows, planes);
    CPLPopErrorHandler();
    if (!read) {
        snprintf(r->error, sizeof r->error, "%s: cannot read rows %d to %d: %s", r->path, row,
                 row + rows - 1, CPLGetLastErrorMsg());
        return ERR_FORMAT;
    }
    if (r->south_up)
        for (int b = 0; b < r->band_count; b++) flip_rows(planes + (size_t)b * count, cols, rows);
    convert(r, planes, count);
    return OK;
}

const char *raster_error(const struct raster *r)
{
    return r->error;
}

status raster_to_ellipsoid(struct raster *r, tile_id id, float *heights)
{
    if (!r->vertical) return OK;
    status s = vertical_to_ellipsoid(r->vertical, id, heights);
    if (s)
        snprintf(r->error, sizeof r->error,
                 "%s: PROJ gives no height of its vertical datum at tile %d/%d/%d", r->path,
                 id.zoom, id.row, id.col);
    return s;
}

status raster_read(struct raster *r, int col, int row, int cols, int rows, float *planes)
{
    if (!r->memory) return read_file(r, col, row, cols, rows, planes);
    for (int y = 0; y < rows; y++)
        memcpy(planes + (size_t)y * (size_t)cols,
               r->memory + (size_t)(row + y) * (size_t)r->grid.width + (size_t)col,
               (size_t)cols * sizeof *planes);
    return OK;
}
