// GDAL's warper does the work, into a memory dataset with the tile's grid. Handles are kept in a
// list and used by one call at a time.
#include "planet/source_raster.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <errno.h>
#include <gdal.h>
#include <gdal_alg.h>
#include <gdal_utils.h>
#include <math.h>
#include <ogr_srs_api.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/vec.h"
#include "planet/circle.h"
#include "planet/import_raster.h"

#define DEG (180 / M_PI)

enum { SAMPLES = TILE_SIZE * TILE_SIZE };

// The raster as GDAL has it, as bands of heights or of colour and coverage, and these closed where
// they go all the way round.
struct handle {
    GDALDatasetH raw, bands, closed;
    struct handle *next;
};

struct source_raster {
    struct source source;
    char *path;
    const struct plane_map *map; // NULL: on the globe
    enum tile_layer layer;
    int zoom;
    bool geographic;
    double west, south, east, north; // degrees, in the raster's own turn
    double step;                     // degrees of latitude a sample
    char *wkt;                       // of longitude and latitude on the planet
    pthread_mutex_t lock;
    struct handle *idle;
    atomic_bool told;
    atomic_uint_fast64_t corrupt;
};

static status fault(const char *path, status s, const char *what)
{
    log_error("%s: %s", path, what);
    return s;
}

// Metres in a unit of height.
static double metres_of(const char *unit)
{
    static const struct {
        const char *name;
        double metres;
    } units[] = {{"ft", 0.3048},
                 {"foot", 0.3048},
                 {"feet", 0.3048},
                 {"us-ft", 1200.0 / 3937},
                 {"US survey foot", 1200.0 / 3937},
                 {"km", 1000},
                 {"kilometre", 1000},
                 {"kilometer", 1000},
                 {"cm", 0.01},
                 {"mm", 0.001},
                 {"dm", 0.1}};
    for (size_t i = 0; unit && i < sizeof units / sizeof *units; i++)
        if (strcasecmp(unit, units[i].name) == 0) return units[i].metres;
    return 1;
}

static bool is_bytes(GDALDatasetH d)
{
    return GDALGetRasterDataType(GDALGetRasterBand(d, 1)) == GDT_Byte;
}

static bool has_palette(GDALDatasetH d)
{
    return GDALGetRasterColorTable(GDALGetRasterBand(d, 1)) != NULL;
}

static enum tile_layer layer_by_bands(GDALDatasetH d)
{
    bool color = GDALGetRasterCount(d) >= 3 || has_palette(d) || is_bytes(d);
    return color ? LAYER_COLOR : LAYER_HEIGHT;
}

static GDALDatasetH translate(GDALDatasetH d, char **args)
{
    GDALTranslateOptions *options = GDALTranslateOptionsNew(args, NULL);
    GDALDatasetH out = options ? GDALTranslate("", d, options, NULL) : NULL;
    GDALTranslateOptionsFree(options);
    CSLDestroy(args);
    return out;
}

static char **add(char **args, const char *a, const char *b)
{
    return CSLAddString(CSLAddString(args, a), b);
}

// Heights in metres: the raster itself, or what unscales it.
static GDALDatasetH height_bands(GDALDatasetH d)
{
    GDALRasterBandH band = GDALGetRasterBand(d, 1);
    int scaled = 0, shifted = 0;
    double scale = GDALGetRasterScale(band, &scaled), shift = GDALGetRasterOffset(band, &shifted);
    scaled = (scaled && scale != 1) || (shifted && shift != 0);
    char **args = add(add(NULL, "-of", "VRT"), "-b", "1");
    if (scaled) args = CSLAddString(add(args, "-ot", "Float32"), "-unscale");
    return translate(d, args);
}

static GDALDatasetH color_bands(GDALDatasetH d)
{
    char **args = add(NULL, "-of", "VRT");
    int count = GDALGetRasterCount(d), last = count == 2 || count >= 4 ? (count == 2 ? 2 : 4) : 0;
    bool alpha =
        last && GDALGetRasterColorInterpretation(GDALGetRasterBand(d, last)) == GCI_AlphaBand;
    static const char *const numbers[] = {"", "1", "2", "3", "4"};
    if (has_palette(d)) {
        args = add(args, "-expand", "rgba");
        return translate(d, args);
    }
    for (int i = 1; i <= 3; i++) args = add(args, "-b", numbers[count >= 3 ? i : 1]);
    if (alpha) args = add(args, "-b", numbers[last]);
    if (!is_bytes(d)) {
        args = add(add(args, "-ot", "Byte"), "-scale", "0");
        args = CSLAddString(add(args, "65535", "0"), "255");
    }
    return translate(d, args);
}

static void handle_close(struct handle **handle)
{
    if (!*handle) return;
    if ((*handle)->closed) GDALReleaseDataset((*handle)->closed);
    if ((*handle)->bands) GDALClose((*handle)->bands);
    if ((*handle)->raw) GDALClose((*handle)->raw);
    free(*handle);
    *handle = NULL;
}

// Reference system of the raster; longitude and latitude when it has none and its corners could be
// such. Released by the caller; NULL: not to be placed.
static OGRSpatialReferenceH reference_of(GDALDatasetH d)
{
    double g[6];
    OGRSpatialReferenceH own = GDALGetSpatialRef(d);
    if (!own) own = GDALGetGCPSpatialRef(d);
    bool placed = GDALGetGeoTransform(d, g) == CE_None;
    if (!placed && !GDALGetGCPCount(d)) return NULL;
    OGRSpatialReferenceH srs = own ? OSRClone(own) : NULL;
    if (!srs && placed) {
        double east = g[0] + g[1] * GDALGetRasterXSize(d),
               south = g[3] + g[5] * GDALGetRasterYSize(d);
        if (g[0] < -361 || east > 361 || g[3] > 90.5 || south < -90.5) return NULL;
        srs = OSRNewSpatialReference(NULL);
        OSRSetWellKnownGeogCS(srs, "WGS84");
    }
    if (srs) OSRSetAxisMappingStrategy(srs, OAMS_TRADITIONAL_GIS_ORDER);
    return srs;
}

// Bands without a reference system are given theirs; false when it is not known.
static bool give_reference(struct handle *h)
{
    OGRSpatialReferenceH srs = reference_of(h->raw);
    if (srs && !GDALGetSpatialRef(h->bands) && !GDALGetGCPSpatialRef(h->bands))
        GDALSetSpatialRef(h->bands, srs);
    OSRDestroySpatialReference(srs);
    return srs != NULL;
}

static void lay_on(struct handle *h, const char *path, const struct plane_map *map)
{
    GDALDatasetH flat = plane_map_place(map, path, h->bands);
    if (flat != h->bands) GDALReleaseDataset(h->bands);
    h->bands = flat;
}

static struct handle *handle_open(const char *path, const struct plane_map *map,
                                  enum tile_layer *layer)
{
    struct handle *h = NEW(struct handle);
    h->raw = GDALOpenEx(path, GDAL_OF_RASTER | GDAL_OF_READONLY, NULL, NULL, NULL);
    if (h->raw && GDALGetRasterCount(h->raw) > 0) {
        if (*layer == LAYER_COUNT) *layer = layer_by_bands(h->raw);
        h->bands = *layer == LAYER_HEIGHT ? height_bands(h->raw) : color_bands(h->raw);
        if (h->bands && give_reference(h) && map) lay_on(h, path, map);
    }
    if (h->bands) h->closed = circle_close(h->bands);
    else handle_close(&h);
    return h;
}

static struct handle *checkout(struct source_raster *r)
{
    pthread_mutex_lock(&r->lock);
    struct handle *h = r->idle;
    if (h) r->idle = h->next;
    pthread_mutex_unlock(&r->lock);
    return h ? h : handle_open(r->path, r->map, &r->layer);
}

static void checkin(struct source_raster *r, struct handle *h)
{
    pthread_mutex_lock(&r->lock);
    h->next = r->idle;
    r->idle = h;
    pthread_mutex_unlock(&r->lock);
}

static bool is_earth(double semi_major)
{
    return semi_major > 6.3e6 && semi_major < 6.5e6;
}

// Longitude and latitude of the planet, as text; and its ellipsoid.
static char *planet_wkt(OGRSpatialReferenceH srs, geo_ellipsoid *ellipsoid)
{
    OGRErr a_bad = OGRERR_NONE, b_bad = OGRERR_NONE;
    double a = OSRGetSemiMajor(srs, &a_bad), b = OSRGetSemiMinor(srs, &b_bad);
    OGRSpatialReferenceH lonlat;
    char *wkt = NULL;
    if (a_bad || b_bad || is_earth(a)) {
        lonlat = OSRNewSpatialReference(NULL);
        OSRSetWellKnownGeogCS(lonlat, "WGS84");
        *ellipsoid = GEO_WGS84;
    } else {
        lonlat = OSRCloneGeogCS(srs);
        *ellipsoid = (geo_ellipsoid){.a = a, .b = b};
    }
    if (lonlat) OSRExportToWkt(lonlat, &wkt);
    OSRDestroySpatialReference(lonlat);
    return wkt;
}

// Where the raster lies and how fine it is.
static status place(struct source_raster *r, GDALDatasetH d)
{
    OGRSpatialReferenceH srs = reference_of(d);
    char *source = NULL, *wkt = srs ? planet_wkt(srs, &r->source.meta.ellipsoid) : NULL;
    if (!wkt) {
        OSRDestroySpatialReference(srs);
        return fault(r->path, ERR_ARGUMENT, "no georeference: where it lies is not said");
    }
    r->geographic = OSRIsGeographic(srs);
    r->wkt = NEW_ARRAY(char, strlen(wkt) + 1);
    strcpy(r->wkt, wkt);
    OSRExportToWkt(srs, &source);
    OSRDestroySpatialReference(srs);
    double g[6];
    int width, height;
    void *t = GDALCreateGenImgProjTransformer(d, source, NULL, wkt, TRUE, 0, 1);
    bool good =
        t && GDALSuggestedWarpOutput(d, GDALGenImgProjTransform, t, g, &width, &height) == CE_None;
    if (t) GDALDestroyGenImgProjTransformer(t);
    CPLFree(wkt);
    CPLFree(source);
    if (!good) return fault(r->path, ERR_ARGUMENT, "cannot be placed on the planet");
    r->west = g[0];
    r->east = g[0] + g[1] * width;
    r->north = g[3];
    r->south = g[3] + g[5] * height;
    r->step = fabs(g[5]);
    r->zoom = raster_zoom_of_step(r->step / DEG);
    return OK;
}

// Bounds of heights: those that the file states, else wide.
static void height_range(struct source_raster *r, GDALDatasetH d)
{
    int has_min = 0, has_max = 0;
    GDALRasterBandH band = GDALGetRasterBand(d, 1);
    double min = GDALGetRasterMinimum(band, &has_min), max = GDALGetRasterMaximum(band, &has_max);
    bool stated = has_min && has_max && isfinite(min) && isfinite(max) && min <= max;
    r->source.meta.height_min = stated ? min : -12000;
    r->source.meta.height_max = stated ? max : 9000;
}

// The tile's bounds in the raster's turn; false when they do not meet.
static bool bounds_of(const struct source_raster *r, tile_id id, double g[6])
{
    double west, south, east, north;
    grid_bounds(id, &west, &south, &east, &north);
    west *= DEG, south *= DEG, east *= DEG, north *= DEG;
    if (r->geographic && east <= r->west + 1e-9) west += 360, east += 360;
    g[0] = west;
    g[1] = (east - west) / TILE_SIZE;
    g[2] = g[4] = 0;
    g[3] = north;
    g[5] = (south - north) / TILE_SIZE;
    return west < r->east && east > r->west && south < r->north && north > r->south;
}

static GDALDatasetH make_target(const struct source_raster *r, const double g[6])
{
    bool heights = r->layer == LAYER_HEIGHT;
    double place_at[6];
    memcpy(place_at, g, sizeof place_at);
    GDALDatasetH d = GDALCreate(GDALGetDriverByName("MEM"), "", TILE_SIZE, TILE_SIZE,
                                heights ? 1 : 4, heights ? GDT_Float32 : GDT_Byte, NULL);
    if (!d) return NULL;
    GDALSetGeoTransform(d, place_at);
    GDALSetProjection(d, r->wkt);
    if (heights) {
        GDALRasterBandH band = GDALGetRasterBand(d, 1);
        GDALSetRasterNoDataValue(band, (double)NAN);
        GDALFillRaster(band, (double)NAN, 0);
    } else GDALSetRasterColorInterpretation(GDALGetRasterBand(d, 4), GCI_AlphaBand);
    return d;
}

static bool warp(GDALDatasetH from, GDALDatasetH target, const char *how)
{
    char **args = add(add(NULL, "-r", how), "-ovr", "AUTO");
    GDALWarpAppOptions *options = GDALWarpAppOptionsNew(args, NULL);
    CSLDestroy(args);
    int failed = 0;
    bool good = options && GDALWarp(NULL, target, 1, &from, options, &failed) && !failed;
    GDALWarpAppOptionsFree(options);
    return good;
}

// Of a raster around the globe interpolation at one edge needs what lies beyond the other. For
// means, which need overviews, what a tile has beyond one edge comes from the other.
static bool warp_around(const struct source_raster *r, struct handle *h, GDALDatasetH target,
                        int zoom, double g[6])
{
    double east = g[0] + TILE_SIZE * g[1];
    bool finer = r->step / DEG < 0.75 * grid_step_lat(zoom);
    const char *how = finer ? "average" : "bilinear";
    if (h->closed && !finer) return warp(h->closed, target, how);
    bool around = r->geographic && r->east - r->west > 359, good = true;
    if (around && (g[0] < r->west || east > r->east)) {
        double turned[6] = {g[0] + (g[0] < r->west ? 360 : -360), g[1], 0, g[3], 0, g[5]};
        GDALSetGeoTransform(target, turned);
        good = warp(h->bands, target, how);
        GDALSetGeoTransform(target, g);
    }
    return good && warp(h->bands, target, how);
}

static bool take_heights(struct handle *h, GDALDatasetH target, float *out)
{
    double metres = metres_of(GDALGetRasterUnitType(GDALGetRasterBand(h->raw, 1)));
    if (GDALRasterIO(GDALGetRasterBand(target, 1), GF_Read, 0, 0, TILE_SIZE, TILE_SIZE, out,
                     TILE_SIZE, TILE_SIZE, GDT_Float32, 0, 0) != CE_None)
        return false;
    // What no planet has is no data.
    for (int i = 0; i < SAMPLES; i++)
        out[i] = fabsf(out[i]) < 5e6f ? (float)(out[i] * metres) : NAN;
    return true;
}

static bool take_pixels(GDALDatasetH target, uint8_t *out)
{
    if (GDALDatasetRasterIO(target, GF_Read, 0, 0, TILE_SIZE, TILE_SIZE, out, TILE_SIZE, TILE_SIZE,
                            GDT_Byte, 4, NULL, 4, 4 * TILE_SIZE, 1) != CE_None)
        return false;
    for (int i = 0; i < SAMPLES; i++)
        for (int c = 0; c < 3; c++)
            out[4 * i + c] = (uint8_t)((out[4 * i + c] * out[4 * i + 3] + 127) / 255);
    return true;
}

static bool raster_has(const struct source *source, tile_id id)
{
    const struct source_raster *r = (const struct source_raster *)source;
    return id.layer == r->layer && id.zoom <= r->zoom;
}

static void fill_blank(tile_id id, void *samples)
{
    if (id.layer == LAYER_HEIGHT)
        for (int i = 0; i < SAMPLES; i++) ((float *)samples)[i] = NAN;
    else memset(samples, 0, SAMPLES * 4);
}

static int held(int i, double first, double last)
{
    double low = fmax(ceil(first), 0), high = fmin(floor(last), TILE_SIZE - 1);
    return (int)clamp_double(i, low, high);
}

// The raster that a map is of goes on beyond its edges as its nearest samples in the tile, of four
// bytes each: what is interpolated there falls to nothing otherwise.
static void carry_on(const struct source_raster *r, const double g[6], void *samples)
{
    const geo_ellipsoid map = plane_map_body(r->map);
    bool whole = r->west <= map.west * DEG && r->east >= map.east * DEG &&
                 r->south <= map.south * DEG && r->north >= map.north * DEG;
    double west = (r->west - g[0]) / g[1] - 0.5, east = (r->east - g[0]) / g[1] - 0.5;
    double north = (r->north - g[3]) / g[5] - 0.5, south = (r->south - g[3]) / g[5] - 0.5;
    bool meets = floor(east) >= fmax(ceil(west), 0) && ceil(west) < TILE_SIZE &&
                 floor(south) >= fmax(ceil(north), 0) && ceil(north) < TILE_SIZE;
    uint32_t *s = samples;
    for (int i = 0; whole && meets && i < SAMPLES; i++) {
        int y = held(i / TILE_SIZE, north, south), x = held(i % TILE_SIZE, west, east);
        s[i] = s[y * TILE_SIZE + x];
    }
}

static status read_warped(struct source *source, tile_id id, struct want *want, void *samples,
                          double *until_s)
{
    (void)want;
    (void)until_s;
    struct source_raster *r = (struct source_raster *)source;
    double g[6];
    if (!raster_has(source, id)) return ERR_NOT_FOUND;
    if (!bounds_of(r, id, g)) {
        fill_blank(id, samples);
        return OK;
    }
    CPLPushErrorHandler(CPLQuietErrorHandler);
    struct handle *h = checkout(r);
    GDALDatasetH target = h ? make_target(r, g) : NULL;
    bool good = target && warp_around(r, h, target, id.zoom, g);
    if (good)
        good = id.layer == LAYER_HEIGHT ? take_heights(h, target, samples)
                                        : take_pixels(target, samples);
    if (good && r->map) carry_on(r, g, samples);
    if (!good) {
        r->corrupt++;
        if (!atomic_exchange(&r->told, true))
            log_warn("%s: tile %s/%d/%d/%d cannot be read: %s", r->path, tile_layer_name(id.layer),
                     id.zoom, id.row, id.col, CPLGetLastErrorMsg());
    }
    if (target) GDALClose(target);
    if (h) checkin(r, h);
    CPLPopErrorHandler();
    return good ? OK : ERR_FORMAT;
}

static void raster_counters(struct source *source, struct source_counters *out)
{
    out->corrupt = ((struct source_raster *)source)->corrupt;
}

static void raster_close_source(struct source *source)
{
    struct source_raster *r = (struct source_raster *)source;
    while (r->idle) {
        struct handle *h = r->idle;
        r->idle = h->next;
        handle_close(&h);
    }
    pthread_mutex_destroy(&r->lock);
    free(r->wkt);
    free(r->path);
    free(r);
}

static const struct source_ops raster_ops = {raster_has, read_warped, raster_counters,
                                             raster_close_source};

static void name_after(const char *path, char *out, size_t size)
{
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    snprintf(out, size, "%.*s", (int)strcspn(name, "."), name);
}

static status open_first(struct source_raster *r)
{
    r->idle = handle_open(r->path, r->map, &r->layer);
    if (!r->idle && access(r->path, F_OK) != 0 && errno == ENOENT && !strstr(r->path, ":"))
        return fault(r->path, ERR_NOT_FOUND, strerror(ENOENT));
    if (!r->idle)
        return fault(r->path, ERR_FORMAT, "neither a planet file nor a raster that GDAL reads");
    status s = place(r, r->map ? r->idle->bands : r->idle->raw);
    if (r->map) r->source.meta.ellipsoid = plane_map_body(r->map);
    if (!s && r->layer == LAYER_HEIGHT) height_range(r, r->idle->bands);
    return s;
}

status source_raster_open(const char *path, enum tile_layer layer, struct source **out)
{
    return source_raster_open_on(path, layer, NULL, out);
}

status source_raster_open_on(const char *path, enum tile_layer layer, const struct plane_map *map,
                             struct source **out)
{
    GDALAllRegister();
    struct source_raster *r = NEW(struct source_raster);
    r->path = NEW_ARRAY(char, strlen(path) + 1);
    strcpy(r->path, path);
    r->layer = layer;
    r->map = map;
    r->source = (struct source){.ops = &raster_ops, .path = r->path, .gaps_final = true};
    pthread_mutex_init(&r->lock, NULL);
    CPLPushErrorHandler(CPLQuietErrorHandler);
    status s = open_first(r);
    CPLPopErrorHandler();
    struct planet_meta *m = &r->source.meta;
    name_after(path, m->name, sizeof m->name);
    m->complete = true;
    for (int i = 0; i < LAYER_COUNT; i++) m->max_zoom[i] = i == (int)r->layer ? r->zoom : -1;
    *out = &r->source;
    if (s) source_close(out);
    return s;
}
