#include "analytic_planet.h"

#include <gdal.h>
#include <ogr_srs_api.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/import.h"

// amplitude sin(wave . n + phase); |wave| is 2, 5, 11, 23 and 40 rad / rad.
static const struct {
    double amplitude;
    dvec3 wave;
    double phase;
} waves[] = {
    {2000, {1.2, -0.8, 1.3856406460551018}, 0.3},
    {1000, {-3.0, 2.4, 3.2}, 1.1},
    {600, {2.0, 9.0, -6.0}, 2.0},
    {300, {-15.0, -6.0, 16.370705543744901}, 0.7},
    {100, {24.0, -28.0, 15.491933384829668}, 1.9},
};

static double field(dvec3 n)
{
    double h = 0;
    for (size_t i = 0; i < sizeof waves / sizeof *waves; i++)
        h += waves[i].amplitude * sin(dvec3_dot(waves[i].wave, n) + waves[i].phase);
    return h;
}

double analytic_height_rotated(const dmat3 *rotation, double lat, double lon)
{
    dvec3 n = {cos(lat) * cos(lon), cos(lat) * sin(lon), sin(lat)};
    return field(rotation ? dmat3_mul(dmat3_transpose(*rotation), n) : n);
}

double analytic_height(double lat, double lon)
{
    return analytic_height_rotated(NULL, lat, lon);
}

static GDALDatasetH create_raster(const char *path, int width, int height)
{
    GDALAllRegister();
    GDALDatasetH d =
        GDALCreate(GDALGetDriverByName("GTiff"), path, width, height, 1, GDT_Float32, NULL);
    if (!d) return NULL;
    double transform[6] = {-180, 360.0 / width, 0, 90, 0, -180.0 / height};
    GDALSetGeoTransform(d, transform);
    OGRSpatialReferenceH srs = OSRNewSpatialReference(NULL);
    OSRSetWellKnownGeogCS(srs, "WGS84");
    GDALSetSpatialRef(d, srs);
    OSRDestroySpatialReference(srs);
    return d;
}

static status write_raster(const char *path, int zoom, const dmat3 *rotation)
{
    int height = TILE_SIZE << zoom, width = 2 * height;
    GDALDatasetH d = create_raster(path, width, height);
    if (!d) {
        log_error("%s: cannot be created", path);
        return ERR_IO;
    }
    float *line = NEW_ARRAY(float, (size_t)width);
    CPLErr error = CE_None;
    for (int y = 0; y < height && error == CE_None; y++) {
        double lat = M_PI / 2 - (y + 0.5) * M_PI / height;
        for (int x = 0; x < width; x++)
            line[x] =
                (float)analytic_height_rotated(rotation, lat, -M_PI + (x + 0.5) * 2 * M_PI / width);
        error = GDALRasterIO(GDALGetRasterBand(d, 1), GF_Write, 0, y, width, 1, line, width, 1,
                             GDT_Float32, 0, 0);
    }
    free(line);
    GDALClose(d);
    return error == CE_None ? OK : ERR_IO;
}

status analytic_planet_make_rotated(const char *path, int zoom, const dmat3 *rotation,
                                    geo_ellipsoid ellipsoid)
{
    char *raster;
    if (asprintf(&raster, "%s.tif", path) < 0) abort();
    status s = write_raster(raster, zoom, rotation);
    import_source source = {.layer = LAYER_HEIGHT, .path = raster};
    import_params params = {.sources = &source,
                            .source_count = 1,
                            .output = path,
                            .name = "Analytic",
                            .ellipsoid = ellipsoid,
                            .force = true};
    if (!s) s = import_run(&params);
    unlink(raster);
    free(raster);
    return s;
}

status analytic_planet_make(const char *path, int zoom)
{
    return analytic_planet_make_rotated(path, zoom, NULL, GEO_WGS84);
}
