#include "planet/import_warp.h"

#include <gdal.h>
#include <gdal_alg.h>
#include <gdal_utils.h>
#include <cpl_conv.h>
#include <cpl_string.h>
#include <ogr_srs_api.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/log.h"
#include "base/memory.h"
// Points a side at which the raster's place is looked at; the outermost stand just inside the
// edges, so that an edge at 180 degrees keeps its sign.
enum { PROBES = 65 };
#define PROBE_INSET 0.01
#define DEG         (180 / M_PI)

static bool is_earth(double semi_major)
{
    return semi_major > 6.3e6 && semi_major < 6.5e6;
}

static OGRSpatialReferenceH source_srs(GDALDatasetH dataset)
{
    OGRSpatialReferenceH srs = GDALGetSpatialRef(dataset);
    return srs ? srs : GDALGetGCPSpatialRef(dataset);
}

// WGS84 on the Earth; elsewhere the source's own longitude and latitude. Released by the caller.
static OGRSpatialReferenceH planet_srs(OGRSpatialReferenceH source, geo_ellipsoid ellipsoid)
{
    OGRErr failed = OGRERR_NONE;
    double a = OSRGetSemiMajor(source, &failed);
    OGRSpatialReferenceH srs;
    if (failed == OGRERR_NONE && is_earth(a) && is_earth(ellipsoid.a)) {
        srs = OSRNewSpatialReference(NULL);
        OSRSetWellKnownGeogCS(srs, "WGS84");
    } else {
        srs = OSRCloneGeogCS(source);
    }
    if (srs) OSRSetAxisMappingStrategy(srs, OAMS_TRADITIONAL_GIS_ORDER);
    return srs;
}

// Do the raster's x run along longitude and its y along latitude?
static bool is_longitude_first(OGRSpatialReferenceH srs)
{
    int count = 0;
    const int *axes = OSRGetDataAxisToSRSAxisMapping(srs, &count);
    if (!axes || count < 2 || axes[0] < 1) return false;
    OGRAxisOrientation first = OAO_Other;
    const char *name = OSRGetAxis(srs, NULL, axes[0] - 1, &first);
    return !name || first == OAO_East || first == OAO_Other;
}

bool warp_is_geographic(void *dataset, geo_ellipsoid ellipsoid)
{
    double g[6];
    OGRSpatialReferenceH own = source_srs(dataset);
    if (GDALGetGeoTransform(dataset, g) != CE_None || g[2] != 0 || g[4] != 0) return false;
    if (!own || !OSRIsGeographic(own) || g[1] < 0 || !is_longitude_first(own)) return false;
    OGRSpatialReferenceH source = OSRClone(own), target = planet_srs(own, ellipsoid);
    OSRSetAxisMappingStrategy(source, OAMS_TRADITIONAL_GIS_ORDER);
    bool same = OSRIsSame(source, target);
    OGRCoordinateTransformationH shift =
        same ? NULL : OCTNewCoordinateTransformation(source, target);
    if (shift) {
        double x = g[0] + g[1] * GDALGetRasterXSize(dataset) / 2.0, x0 = x;
        double y = g[3] + g[5] * GDALGetRasterYSize(dataset) / 2.0, y0 = y;
        same = OCTTransform(shift, 1, &x, &y, NULL) && fabs(x - x0) <= 0.1 * fabs(g[1]) &&
               fabs(y - y0) <= 0.1 * fabs(g[5]);
        OCTDestroyCoordinateTransformation(shift);
    }
    OSRDestroySpatialReference(source);
    OSRDestroySpatialReference(target);
    return same;
}

struct place {
    double west, south, east, north; // degrees
    double step;                     // sample distance on the ground, as degrees of latitude
    bool full_circle, holds_pole;
};

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double turn_deg(double lon)
{
    return lon - 360 * floor((lon + 180) / 360);
}

// Is the pole at `lat` (+-90) inside the raster?
static bool holds_pole(void *transformer, double lat, int width, int height)
{
    double x = 0, y = lat, z = 0;
    int good = 0;
    if (!GDALGenImgProjTransform(transformer, TRUE, 1, &x, &y, &z, &good) || !good) return false;
    if (!(x >= 0 && x <= width && y >= 0 && y <= height)) return false;
    double back_x = x, back_y = y;
    if (!GDALGenImgProjTransform(transformer, FALSE, 1, &back_x, &back_y, &z, &good) || !good)
        return false;
    return fabs(back_y - lat) < 0.01;
}

struct probes {
    double lon[3 * PROBES * PROBES], lat[3 * PROBES * PROBES], z[3 * PROBES * PROBES];
    int good[3 * PROBES * PROBES];
    double area[PROBES * PROBES];
};

// Longitude and latitude of each probe, of the point a sample right of it and of the point a sample
// below.
static void transform_probes(void *transformer, int width, int height, struct probes *p)
{
    for (int i = 0; i < PROBES * PROBES; i++) {
        double x = PROBE_INSET + (width - 1 - 2 * PROBE_INSET) * (i % PROBES) / (PROBES - 1.0);
        double y = PROBE_INSET + (height - 1 - 2 * PROBE_INSET) * (i / PROBES) / (PROBES - 1.0);
        if (i % PROBES == PROBES - 1) x += 1;
        if (i / PROBES == PROBES - 1) y += 1;
        int right = i % PROBES == PROBES - 1 ? -1 : 1, down = i / PROBES == PROBES - 1 ? -1 : 1;
        for (int k = 0; k < 3; k++) {
            p->lon[3 * i + k] = x + (k == 1) * right;
            p->lat[3 * i + k] = y + (k == 2) * down;
        }
    }
    GDALGenImgProjTransform(transformer, FALSE, 3 * PROBES * PROBES, p->lon, p->lat, p->z, p->good);
    for (int i = 0; i < 3 * PROBES * PROBES; i++)
        if (!(fabs(p->lat[i]) <= 90) || !isfinite(p->lon[i])) p->good[i] = 0;
}

static bool measure_step(struct probes *p, double *step)
{
    int n = 0;
    for (int i = 0; i < PROBES * PROBES; i++) {
        const int *good = p->good + 3 * i;
        const double *lon = p->lon + 3 * i, *lat = p->lat + 3 * i;
        if (!good[0] || !good[1] || !good[2]) continue;
        double c = cos(lat[0] / DEG);
        double ax = c * turn_deg(lon[1] - lon[0]), ay = lat[1] - lat[0];
        double bx = c * turn_deg(lon[2] - lon[0]), by = lat[2] - lat[0];
        double area = fabs(ax * by - ay * bx);
        if (area > 0 && isfinite(area)) p->area[n++] = area;
    }
    if (!n) return false;
    qsort(p->area, (size_t)n, sizeof *p->area, compare_doubles);
    *step = sqrt(p->area[n / 2]);
    return true;
}

static void measure_bounds(const struct probes *p, struct place *place)
{
    int middle = 3 * (PROBES / 2 * PROBES + PROBES / 2);
    for (int i = 0; !p->good[middle] && i < PROBES * PROBES; i++)
        if (p->good[3 * i]) middle = 3 * i;
    double centre = p->lon[middle], west = 0, east = 0;
    place->south = place->north = p->lat[middle];
    for (int i = 0; i < PROBES * PROBES; i++) {
        if (!p->good[3 * i]) continue;
        double lon = turn_deg(p->lon[3 * i] - centre);
        west = fmin(west, lon);
        east = fmax(east, lon);
        place->south = fmin(place->south, p->lat[3 * i]);
        place->north = fmax(place->north, p->lat[3 * i]);
    }
    place->west = turn_deg(centre + west);
    place->east = place->west + (east - west);
    place->full_circle = east - west > 355;
}

static bool find_place(GDALDatasetH dataset, void *transformer, struct place *place)
{
    int width = GDALGetRasterXSize(dataset), height = GDALGetRasterYSize(dataset);
    struct probes *p = NEW(struct probes);
    transform_probes(transformer, width, height, p);
    bool found = measure_step(p, &place->step);
    if (found) {
        measure_bounds(p, place);
        bool north = holds_pole(transformer, 90, width, height);
        bool south = holds_pole(transformer, -90, width, height);
        place->holds_pole = north || south;
        place->full_circle |= place->holds_pole;
        // A probe stands for the ground up to half way to its neighbours.
        double margin = 2 * place->step + (place->north - place->south) / (PROBES - 1);
        place->north = north ? 90 : fmin(90, place->north + margin);
        place->south = south ? -90 : fmax(-90, place->south - margin);
        margin = 2 * place->step + (place->east - place->west) / (PROBES - 1);
        place->west -= margin;
        place->east += margin;
        if (place->east - place->west >= 360) place->full_circle = true;
    }
    free(p);
    return found;
}

// The edges of the raster, once around.
static void find_outline(GDALDatasetH dataset, void *transformer, const struct place *place,
                         raster_outline *out)
{
    enum { SIDE = OUTLINE_POINTS / 4 };
    double right = GDALGetRasterXSize(dataset) - PROBE_INSET;
    double bottom = GDALGetRasterYSize(dataset) - PROBE_INSET;
    double z[OUTLINE_POINTS] = {0};
    int good[OUTLINE_POINTS];
    out->count = 0;
    if (place->full_circle && !place->holds_pole) return;
    for (int i = 0; i < OUTLINE_POINTS; i++) {
        double t = (double)(i % SIDE) / SIDE, back = 1 - t;
        double x[4] = {t, 1, back, 0}, y[4] = {0, t, 1, back};
        out->lon[i] = PROBE_INSET + x[i / SIDE] * (right - PROBE_INSET);
        out->lat[i] = PROBE_INSET + y[i / SIDE] * (bottom - PROBE_INSET);
    }
    GDALGenImgProjTransform(transformer, FALSE, OUTLINE_POINTS, out->lon, out->lat, z, good);
    for (int i = 0; i < OUTLINE_POINTS; i++) {
        if (!good[i] || !isfinite(out->lon[i]) || !(fabs(out->lat[i]) <= 90)) return;
        out->lon[i] /= DEG;
        out->lat[i] /= DEG;
    }
    out->count = OUTLINE_POINTS;
}

// Options of the warp onto the planet's samples at the zoom of place->step.
static char **warp_arguments(const struct place *place, const char *wkt)
{
    int zoom = raster_zoom_of_step(place->step / DEG);
    double step = 180.0 / 256 / exp2(zoom);
    double nearest = place->south > 0 ? place->south : place->north < 0 ? -place->north : 0;
    double wide = step * exp2(floor(log2(1 / cos(nearest / DEG))));
    double west = -180, east = 180;
    if (!place->full_circle) {
        west = -180 + wide * floor((place->west + 180) / wide);
        east = -180 + wide * ceil((place->east + 180) / wide);
    }
    double north = 90 - step * floor((90 - place->north) / step);
    double south = 90 - step * ceil((90 - place->south) / step);
    char **list = NULL;
    list = CSLAddString(list, "-of");
    list = CSLAddString(list, "VRT");
    list = CSLAddString(list, "-ot");
    list = CSLAddString(list, "Float32");
    list = CSLAddString(list, "-dstnodata");
    list = CSLAddString(list, "nan");
    list = CSLAddString(list, "-r");
    list = CSLAddString(list, "cubic");
    list = CSLAddString(list, "-novshift"); // vertical datums are import_vertical's
    list = CSLAddString(list, "-t_srs");
    list = CSLAddString(list, wkt);
    list = CSLAddString(list, "-te");
    list = CSLAddString(list, CPLSPrintf("%.17g", west));
    list = CSLAddString(list, CPLSPrintf("%.17g", south));
    list = CSLAddString(list, CPLSPrintf("%.17g", east));
    list = CSLAddString(list, CPLSPrintf("%.17g", north));
    list = CSLAddString(list, "-ts");
    list = CSLAddString(list, CPLSPrintf("%.0f", round((east - west) / wide)));
    list = CSLAddString(list, CPLSPrintf("%.0f", round((north - south) / step)));
    return list;
}

static status run_warp(GDALDatasetH dataset, const char *path, const struct place *place,
                       const char *wkt, void **out)
{
    char **list = warp_arguments(place, wkt);
    GDALWarpAppOptions *options = GDALWarpAppOptionsNew(list, NULL);
    GDALDatasetH source = dataset;
    *out = options ? GDALWarp("", NULL, 1, &source, options, NULL) : NULL;
    GDALWarpAppOptionsFree(options);
    CSLDestroy(list);
    if (*out) return OK;
    log_error("%s: cannot be warped to longitude and latitude: %s", path, CPLGetLastErrorMsg());
    return ERR_ARGUMENT;
}

status warp_to_geographic(void *dataset, const char *path, geo_ellipsoid ellipsoid, void **out,
                          raster_outline *outline)
{
    *out = NULL;
    OGRSpatialReferenceH target = planet_srs(source_srs(dataset), ellipsoid);
    char *wkt = NULL;
    if (target) OSRExportToWkt(target, &wkt);
    char **options = wkt ? CSLSetNameValue(NULL, "DST_SRS", wkt) : NULL;
    void *transformer = wkt ? GDALCreateGenImgProjTransformer2(dataset, NULL, options) : NULL;
    struct place place = {0};
    status s = OK;
    if (!transformer || !find_place(dataset, transformer, &place)) {
        log_error("%s: its reference system cannot be turned into longitude and latitude: %s", path,
                  CPLGetLastErrorMsg());
        s = ERR_ARGUMENT;
    }
    if (!s) find_outline(dataset, transformer, &place, outline);
    if (!s) s = run_warp(dataset, path, &place, wkt, out);
    if (transformer) GDALDestroyGenImgProjTransformer(transformer);
    CSLDestroy(options);
    CPLFree(wkt);
    if (target) OSRDestroySpatialReference(target);
    return s;
}
