// Two reference systems joined by PROJ, and an affine map. Invariant: the transformations are used
// by one call at a time.
#include "planet/plane_map.h"

#include <cpl_conv.h>
#include <cpl_string.h>
#include <gdal.h>
#include <gdal_alg.h>
#include <gdal_utils.h>
#include <math.h>
#include <ogr_srs_api.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/circle.h"
#include "planet/grid.h"

#define DEG (180 / M_PI)

// Half of the map is no more than this of the radius.
#define HALF_MAX 0.1

// Of the radius, so that air and levels are about the Earth's; samples finer than a zoom of 20 have
// a smaller one.
#define RADIUS_MIN_M 6378137.0
enum { FINEST_ZOOM = 20 };

struct plane_map {
    geo_ellipsoid body;
    double x, y;   // of the map's origin, in the system's units
    double metres; // in a unit
    char *wkt, *geographic_wkt;
    OGRCoordinateTransformationH to_projected, to_geographic;
    pthread_mutex_t lock;
};

static status refuse(const char *path, const char *what)
{
    log_error("%s: %s", path, what);
    return ERR_ARGUMENT;
}

void plane_map_destroy(struct plane_map **map)
{
    struct plane_map *m = *map;
    if (!m) return;
    OCTDestroyCoordinateTransformation(m->to_projected);
    OCTDestroyCoordinateTransformation(m->to_geographic);
    pthread_mutex_destroy(&m->lock);
    CPLFree(m->wkt);
    CPLFree(m->geographic_wkt);
    free(m);
    *map = NULL;
}

geo_ellipsoid plane_map_body(const struct plane_map *m)
{
    return m->body;
}

// The system of longitude and latitude in which the camera's place is given: WGS84 on the Earth.
static OGRSpatialReferenceH geographic_of(OGRSpatialReferenceH srs)
{
    OGRErr bad = OGRERR_NONE;
    double a = OSRGetSemiMajor(srs, &bad);
    OGRSpatialReferenceH g;
    if (bad || (a > 6.3e6 && a < 6.5e6)) {
        g = OSRNewSpatialReference(NULL);
        OSRSetWellKnownGeogCS(g, "WGS84");
    } else g = OSRCloneGeogCS(srs);
    if (g) OSRSetAxisMappingStrategy(g, OAMS_TRADITIONAL_GIS_ORDER);
    return g;
}

static status join(struct plane_map *m, const char *path, OGRSpatialReferenceH srs)
{
    OGRSpatialReferenceH geographic = geographic_of(srs);
    if (geographic) {
        m->to_projected = OCTNewCoordinateTransformation(geographic, srs);
        m->to_geographic = OCTNewCoordinateTransformation(srs, geographic);
        OSRExportToWkt(geographic, &m->geographic_wkt);
    }
    OSRExportToWkt(srs, &m->wkt);
    OSRDestroySpatialReference(geographic);
    if (m->to_projected && m->to_geographic && m->wkt) return OK;
    return refuse(path, "PROJ has no way from its reference system to longitude and latitude");
}

// The metres that a unit of the system has.
static status unit_of(const char *path, OGRSpatialReferenceH srs, double *metres)
{
    char *name = NULL;
    *metres = OSRGetLinearUnits(srs, &name);
    bool known = name && strcmp(name, "unknown") != 0 && *metres > 0 && isfinite(*metres);
    return known ? OK : refuse(path, "its reference system has no unit of length");
}

// Scale, origin and edges: the outermost samples' centres.
static status lay(struct plane_map *m, const char *path, GDALDatasetH d)
{
    double g[6];
    int width = GDALGetRasterXSize(d), height = GDALGetRasterYSize(d), zoom = 0;
    if (GDALGetGeoTransform(d, g) != CE_None)
        return refuse(path, "no georeference: where it lies is not said");
    double across = hypot(g[1], g[4]) * m->metres, down = hypot(g[2], g[5]) * m->metres;
    int column = width / 2, row = height / 2;
    double west = (0.5 - column) * across, east = (width - column - 0.5) * across,
           south = (row + 0.5 - height) * down, north = (row - 0.5) * down,
           farthest = fmax(east, -south); // of an odd number of samples one more
    double least = fmin(across, down), wanted = fmax(RADIUS_MIN_M, farthest / HALF_MAX);
    if (!(least > 0 && isfinite(wanted)) || width < 2 || height < 2)
        return refuse(path, "not a map: it has less than 2 x 2 samples, or none of a size");
    while (zoom < FINEST_ZOOM && least / grid_step_lat(zoom) < wanted) zoom++;
    double radius = least / grid_step_lat(zoom);
    m->x = g[0] + column * g[1] + row * g[2];
    m->y = g[3] + column * g[4] + row * g[5];
    m->body = (geo_ellipsoid){radius,         radius,        south / radius,
                              north / radius, west / radius, east / radius};
    if (farthest <= 2 * HALF_MAX * radius) return OK;
    return refuse(path, "has too many samples across for a map as a plane");
}

static status make(struct plane_map *m, const char *path, GDALDatasetH d, OGRSpatialReferenceH srs)
{
    status s = unit_of(path, srs, &m->metres);
    if (!s) s = join(m, path, srs);
    return s ? s : lay(m, path, d);
}

static status open_with(const char *path, GDALDatasetH d, struct plane_map **out)
{
    OGRSpatialReferenceH own = GDALGetSpatialRef(d), srs = own ? OSRClone(own) : NULL;
    if (!srs || OSRIsGeographic(srs)) {
        OSRDestroySpatialReference(srs);
        return OK;
    }
    OSRSetAxisMappingStrategy(srs, OAMS_TRADITIONAL_GIS_ORDER);
    struct plane_map *m = NEW(struct plane_map);
    pthread_mutex_init(&m->lock, NULL);
    status s = OSRIsProjected(srs)
                   ? make(m, path, d, srs)
                   : refuse(path, "in a local reference system: where on a planet it lies is not "
                                  "said");
    OSRDestroySpatialReference(srs);
    if (s) plane_map_destroy(&m);
    *out = m;
    return s;
}

status plane_map_open(const char *path, struct plane_map **out)
{
    *out = NULL;
    GDALAllRegister();
    CPLPushErrorHandler(CPLQuietErrorHandler);
    GDALDatasetH d = GDALOpenEx(path, GDAL_OF_RASTER | GDAL_OF_READONLY, NULL, NULL, NULL);
    status s = d ? open_with(path, d, out) : OK; // whoever opens it as a source says what is wrong
    if (d) GDALClose(d);
    CPLPopErrorHandler();
    return s;
}

static bool same_system(GDALDatasetH d, const char *wkt)
{
    OGRSpatialReferenceH own = GDALGetSpatialRef(d), map = OSRNewSpatialReference(wkt);
    bool same = own && map && OSRIsSame(own, map);
    OSRDestroySpatialReference(map);
    return same;
}

// The map's edges with a few samples beyond, in the system's units: west, south, east, north.
static void edges_of(const struct plane_map *m, double out[4])
{
    geo_ellipsoid e = m->body;
    double unit = e.a / m->metres, wide = (e.east - e.west) / 64, high = (e.north - e.south) / 64;
    out[0] = m->x + (e.west - wide) * unit;
    out[1] = m->y + (e.south - high) * unit;
    out[2] = m->x + (e.east + wide) * unit;
    out[3] = m->y + (e.north + high) * unit;
}

// The distance of the dataset's samples on the map, in its units, the shortest of nine places,
// along that axis on which they are farther apart. Infinite where it has none.
static double spacing_on(const struct plane_map *m, GDALDatasetH d, const double edges[4])
{
    char **options = CSLSetNameValue(NULL, "DST_SRS", m->wkt);
    void *way = GDALCreateGenImgProjTransformer2(d, NULL, options);
    double least = INFINITY, wide = edges[2] - edges[0], high = edges[3] - edges[1];
    for (int i = 0; way && i < 9; i++) {
        double west = edges[0] + wide * (1 + i % 3) / 4, south = edges[1] + high * (1 + i / 3) / 4;
        double step = wide / 1024, x[3] = {west, west + step, west},
               y[3] = {south, south, south + step}, z[3] = {0};
        int good[3];
        if (!GDALGenImgProjTransform(way, TRUE, 3, x, y, z, good) || !(good[0] & good[1] & good[2]))
            continue;
        double across = hypot(x[1] - x[0], x[2] - x[0]), down = hypot(y[1] - y[0], y[2] - y[0]);
        least = fmin(least, step / fmin(across, down));
    }
    if (way) GDALDestroyGenImgProjTransformer(way);
    CSLDestroy(options);
    return least;
}

static char **add_number(char **list, double value)
{
    char text[32];
    snprintf(text, sizeof text, "%.17g", value);
    return CSLAddString(list, text);
}

// What the dataset has no samples for has no data. The part that the map shows, at half the
// distance that its samples have there, for they are resampled once more: of all the world what
// GDAL would choose can be anything.
static GDALDatasetH warp(const struct plane_map *m, GDALDatasetH d)
{
    bool color = GDALGetRasterDataType(GDALGetRasterBand(d, 1)) == GDT_Byte;
    const char *heights[] = {"-dstnodata", "nan", "-wt", "Float32", "-ot", "Float32", NULL};
    const char *colors[] = {"-dstalpha", NULL};
    const char *both[] = {"-of", "VRT", "-r", "bilinear", "-t_srs", m->wkt, NULL};
    char **list = CSLDuplicate((char **)both);
    for (const char **o = color ? colors : heights; *o; o++) list = CSLAddString(list, *o);
    double edges[4];
    edges_of(m, edges);
    double spacing = spacing_on(m, d, edges);
    if (isfinite(spacing) && spacing > 0) {
        list = CSLAddString(list, "-te");
        for (int i = 0; i < 4; i++) list = add_number(list, edges[i]);
        list = CSLAddString(list, "-tr");
        for (int i = 0; i < 2; i++) list = add_number(list, spacing / 2);
    }
    GDALWarpAppOptions *options = GDALWarpAppOptionsNew(list, NULL);
    GDALDatasetH closed = circle_close(d), from = closed ? closed : d;
    GDALDatasetH out = options ? GDALWarp("", NULL, 1, &from, options, NULL) : NULL;
    if (closed) GDALReleaseDataset(closed); // `out` holds on to it
    GDALWarpAppOptionsFree(options);
    CSLDestroy(list);
    return out;
}

void *plane_map_place(const struct plane_map *m, const char *path, void *dataset)
{
    double g[6];
    GDALDatasetH d = dataset;
    bool upright = GDALGetGeoTransform(d, g) == CE_None && g[2] == 0 && g[4] == 0 && g[5] < 0;
    if (!upright || !same_system(d, m->wkt)) d = warp(m, d);
    if (!d || GDALGetGeoTransform(d, g) != CE_None) {
        log_error("%s: cannot be laid on the map: %s", path, CPLGetLastErrorMsg());
        if (d && d != dataset) GDALClose(d);
        return NULL;
    }
    double degrees = m->metres / m->body.a * DEG;
    double at[6] = {(g[0] - m->x) * degrees, g[1] * degrees, 0, (g[3] - m->y) * degrees, 0,
                    g[5] * degrees};
    GDALSetGeoTransform(d, at);
    GDALSetProjection(d, m->geographic_wkt);
    return d;
}

static void transform(struct plane_map *m, OGRCoordinateTransformationH way, int count, double *x,
                      double *y)
{
    enum { CHUNK = 256 };
    int good[CHUNK];
    pthread_mutex_lock(&m->lock);
    CPLPushErrorHandler(CPLQuietErrorHandler);
    for (int at = 0; at < count; at += CHUNK) {
        int n = count - at < CHUNK ? count - at : CHUNK;
        OCTTransformEx(way, n, x + at, y + at, NULL, good);
        for (int i = 0; i < n; i++)
            if (!good[i]) x[at + i] = y[at + i] = NAN;
    }
    CPLPopErrorHandler();
    pthread_mutex_unlock(&m->lock);
}

void plane_map_from_geographic(struct plane_map *m, int count, double *lat_deg, double *lon_deg)
{
    double degrees = m->metres / m->body.a * DEG;
    transform(m, m->to_projected, count, lon_deg, lat_deg);
    for (int i = 0; i < count; i++) {
        lon_deg[i] = (lon_deg[i] - m->x) * degrees;
        lat_deg[i] = (lat_deg[i] - m->y) * degrees;
    }
}

void plane_map_coordinates(const struct plane_map *m, int count, double *lat_deg, double *lon_deg)
{
    double units = m->body.a / m->metres / DEG;
    for (int i = 0; i < count; i++) {
        lon_deg[i] = lon_deg[i] * units + m->x;
        lat_deg[i] = lat_deg[i] * units + m->y;
    }
}

void plane_map_to_geographic(struct plane_map *m, int count, double *lat_deg, double *lon_deg)
{
    plane_map_coordinates(m, count, lat_deg, lon_deg);
    transform(m, m->to_geographic, count, lon_deg, lat_deg);
}
