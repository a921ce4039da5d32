#include "planet/import_vertical.h"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal.h>
#include <math.h>
#include <ogr_srs_api.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
#include "base/vec.h"

#define DEG (180 / M_PI)
// Points of the surface are at most this far apart in latitude, or a sample.
#define LATTICE_STEP (0.25 / 60 / DEG)

enum { LATTICE_MAX = TILE_SIZE + 1, EGM96 = 5773, EGM2008 = 3855, STRIDE_MAX = 32 };

struct vertical {
    OGRCoordinateTransformationH to_ellipsoid;
    double lon[LATTICE_MAX * LATTICE_MAX], lat[LATTICE_MAX * LATTICE_MAX],
        z[LATTICE_MAX * LATTICE_MAX];
};

// EPSG code of the vertical system a name means; 0: the ellipsoid, -1: none.
static int code_of_name(const char *said)
{
    static const struct {
        const char *name;
        int code;
    } names[] = {{"ellipsoid", 0}, {"egm96", EGM96}, {"egm2008", EGM2008}};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (!strcmp(said, names[i].name)) return names[i].code;
    char *end;
    if (strncmp(said, "EPSG:", 5) != 0) return -1;
    long code = strtol(said + 5, &end, 10);
    return *end || code < 1 || code > 999999 ? -1 : (int)code;
}

// As code_of_name, of what the reference system declares; -1 logged.
static int code_declared(GDALDatasetH dataset, const char *path)
{
    OGRSpatialReferenceH srs = GDALGetSpatialRef(dataset);
    const char *name = srs ? OSRGetAttrValue(srs, "VERT_CS", 0) : NULL;
    if (!name) return 0;
    const char *authority = OSRGetAuthorityName(srs, "VERT_CS");
    const char *code = OSRGetAuthorityCode(srs, "VERT_CS");
    if (authority && code && !strcmp(authority, "EPSG")) return atoi(code);
    const char *datum = OSRGetAttrValue(srs, "VERT_DATUM", 0);
    if (strcasestr(name, "ellipsoid")) return 0;
    if (strstr(name, "EGM96") || (datum && strstr(datum, "EGM96"))) return EGM96;
    if (strstr(name, "EGM2008") || (datum && strstr(datum, "EGM2008"))) return EGM2008;
    log_error("%s: its heights are above \"%s\", which is not known; --vertical says what they are "
              "above",
              path, name);
    return -1;
}

static OGRSpatialReferenceH new_srs(const char *text)
{
    OGRSpatialReferenceH srs = OSRNewSpatialReference(NULL);
    if (OSRSetFromUserInput(srs, text) != OGRERR_NONE) {
        OSRDestroySpatialReference(srs);
        return NULL;
    }
    OSRSetAxisMappingStrategy(srs, OAMS_TRADITIONAL_GIS_ORDER);
    return srs;
}

// NULL when there is no such system, or no exact way from it.
static OGRCoordinateTransformationH find_way(int code)
{
    char text[32];
    snprintf(text, sizeof text, "EPSG:%d", code);
    OGRSpatialReferenceH alone = new_srs(text);
    bool is_vertical = alone && OSRIsVertical(alone);
    if (alone) OSRDestroySpatialReference(alone);
    if (!is_vertical) return NULL;
    snprintf(text, sizeof text, "EPSG:4326+%d", code);
    OGRSpatialReferenceH from = new_srs(text), to = new_srs("EPSG:4979");
    OGRCoordinateTransformationH way = NULL;
    if (from && to) {
        // Without a grid PROJ would leave the heights as they are; that is refused.
        OGRCoordinateTransformationOptionsH options = OCTNewCoordinateTransformationOptions();
        OCTCoordinateTransformationOptionsSetBallparkAllowed(options, FALSE);
        way = OCTNewCoordinateTransformationEx(from, to, options);
        OCTDestroyCoordinateTransformationOptions(options);
    }
    double lon = 10, lat = 50, z = 0;
    if (way && (!OCTTransform(way, 1, &lon, &lat, &z) || !isfinite(z))) {
        OCTDestroyCoordinateTransformation(way);
        way = NULL;
    }
    if (from) OSRDestroySpatialReference(from);
    if (to) OSRDestroySpatialReference(to);
    return way;
}

status vertical_open(void *dataset, const char *path, const char *said, geo_ellipsoid ellipsoid,
                     struct vertical **out)
{
    *out = NULL;
    int code = said ? code_of_name(said) : code_declared(dataset, path);
    if (said && code < 0)
        log_error("%s: vertical datum \"%s\" is not ellipsoid, egm96, egm2008 or EPSG:n", path,
                  said);
    if (code < 0) return ERR_ARGUMENT;
    if (code == 0) return OK;
    if (!(ellipsoid.a > 6.3e6 && ellipsoid.a < 6.5e6)) {
        log_error("%s: heights above EPSG:%d are the Earth's, the planet is another", path, code);
        return ERR_ARGUMENT;
    }
    CPLPushErrorHandler(CPLQuietErrorHandler);
    OGRCoordinateTransformationH way = find_way(code);
    CPLPopErrorHandler();
    if (!way) {
        log_error(
            "%s: no way from heights above EPSG:%d to the ellipsoid: PROJ has no such system, "
            "or its grid is not installed (EGM96's is in Debian's proj-data)",
            path, code);
        return ERR_UNSUPPORTED;
    }
    struct vertical *v = NEW(struct vertical);
    v->to_ellipsoid = way;
    *out = v;
    return OK;
}

void vertical_close(struct vertical **vertical)
{
    if (!*vertical) return;
    OCTDestroyCoordinateTransformation((*vertical)->to_ellipsoid);
    free(*vertical);
    *vertical = NULL;
}

static int stride_of_zoom(int zoom)
{
    int stride = 1;
    while (stride < STRIDE_MAX && 2 * stride * grid_step_lat(zoom) <= LATTICE_STEP) stride *= 2;
    return stride;
}

// The surface at every `stride` samples from the tile's first, one past its last.
static bool fill_lattice(struct vertical *v, tile_id id, int stride, int side)
{
    double west, south, east, north, lon_step = grid_step_lon(id.zoom, id.row);
    grid_bounds(id, &west, &south, &east, &north);
    for (int y = 0; y < side; y++)
        for (int x = 0; x < side; x++) {
            int i = y * side + x;
            double lat = north - (y * stride + 0.5) * grid_step_lat(id.zoom);
            v->lon[i] = geo_wrap_lon(west + (x * stride + 0.5) * lon_step) * DEG;
            v->lat[i] = clamp_double(lat * DEG, -90, 90);
            v->z[i] = 0;
        }
    CPLPushErrorHandler(CPLQuietErrorHandler);
    bool good = OCTTransform(v->to_ellipsoid, side * side, v->lon, v->lat, v->z);
    CPLPopErrorHandler();
    for (int i = 0; good && i < side * side; i++) good = isfinite(v->z[i]);
    return good;
}

status vertical_to_ellipsoid(struct vertical *v, tile_id id, float *heights)
{
    int stride = stride_of_zoom(id.zoom), side = stride == 1 ? TILE_SIZE : TILE_SIZE / stride + 1;
    if (!fill_lattice(v, id, stride, side)) return ERR_FORMAT;
    for (int y = 0; y < TILE_SIZE; y++)
        for (int x = 0; x < TILE_SIZE; x++) {
            const double *z = v->z + y / stride * side + x / stride;
            double shift = z[0];
            if (stride > 1) {
                double s = (double)(x % stride) / stride, t = (double)(y % stride) / stride;
                shift = (1 - t) * ((1 - s) * z[0] + s * z[1]) +
                        t * ((1 - s) * z[side] + s * z[side + 1]);
            }
            heights[y * TILE_SIZE + x] += (float)shift;
        }
    return OK;
}
