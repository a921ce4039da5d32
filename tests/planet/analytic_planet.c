#include "analytic_planet.h"

#include <gdal.h>
#include <ogr_srs_api.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "base/log.h"
#include "base/memory.h"
#include "planet/import.h"
#include "planet/planet_writer.h"

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

void analytic_color_rotated(const dmat3 *rotation, double lat, double lon, double rgb[3])
{
    static const dvec3 wave[3] = {{4, 3, 0}, {-2, 3, 4.8}, {0, -5, 4}};
    dvec3 n = {cos(lat) * cos(lon), cos(lat) * sin(lon), sin(lat)};
    if (rotation) n = dmat3_mul(dmat3_transpose(*rotation), n);
    for (int i = 0; i < 3; i++) rgb[i] = 0.5 + 0.3 * sin(dvec3_dot(wave[i], n) + i);
}

static GDALDatasetH create_raster(const char *path, int width, int height, int bands,
                                  GDALDataType type)
{
    GDALAllRegister();
    GDALDatasetH d =
        GDALCreate(GDALGetDriverByName("GTiff"), path, width, height, bands, type, NULL);
    if (!d) return NULL;
    double transform[6] = {-180, 360.0 / width, 0, 90, 0, -180.0 / height};
    GDALSetGeoTransform(d, transform);
    OGRSpatialReferenceH srs = OSRNewSpatialReference(NULL);
    OSRSetWellKnownGeogCS(srs, "WGS84");
    GDALSetSpatialRef(d, srs);
    OSRDestroySpatialReference(srs);
    return d;
}

// One line of samples, `bands` a sample.
typedef void line_function(const dmat3 *rotation, double lat, int width, void *line);

static void height_line(const dmat3 *rotation, double lat, int width, void *line)
{
    float *out = line;
    for (int x = 0; x < width; x++)
        out[x] =
            (float)analytic_height_rotated(rotation, lat, -M_PI + (x + 0.5) * 2 * M_PI / width);
}

static void color_line(const dmat3 *rotation, double lat, int width, void *line)
{
    uint8_t *out = line;
    for (int x = 0; x < width; x++) {
        double rgb[3];
        analytic_color_rotated(rotation, lat, -M_PI + (x + 0.5) * 2 * M_PI / width, rgb);
        for (int i = 0; i < 3; i++) *out++ = (uint8_t)lrint(255 * rgb[i]);
    }
}

static status write_raster(const char *path, int zoom, const dmat3 *rotation, bool color)
{
    int height = TILE_SIZE << zoom, width = 2 * height, bands = color ? 3 : 1;
    GDALDataType type = color ? GDT_Byte : GDT_Float32;
    line_function *fill = color ? color_line : height_line;
    GDALDatasetH d = create_raster(path, width, height, bands, type);
    if (!d) {
        log_error("%s: cannot be created", path);
        return ERR_IO;
    }
    int size = color ? 3 : 4;
    char *line = NEW_ARRAY(char, (size_t)(width * size));
    CPLErr error = CE_None;
    for (int y = 0; y < height && error == CE_None; y++) {
        fill(rotation, M_PI / 2 - (y + 0.5) * M_PI / height, width, line);
        error = GDALDatasetRasterIO(d, GF_Write, 0, y, width, 1, line, width, 1, type, bands, NULL,
                                    size, size * width, color ? 1 : size);
    }
    free(line);
    GDALClose(d);
    return error == CE_None ? OK : ERR_IO;
}

static status put_tile(struct planet_writer *w, const analytic_params *p, tile_id id)
{
    enum { SAMPLES = TILE_SIZE * TILE_SIZE };
    static float heights[SAMPLES];
    static unsigned char pixels[3 * SAMPLES];
    double west, south, east, north, rgb[3];
    float low = ANALYTIC_HEIGHT_MAX, high = -low;
    grid_bounds(id, &west, &south, &east, &north);
    for (int k = 0; k < SAMPLES; k++) {
        double lat = north - (k / TILE_SIZE + 0.5) * grid_step_lat(id.zoom),
               lon = west + (k % TILE_SIZE + 0.5) * grid_step_lon(id.zoom, id.row);
        heights[k] = (float)analytic_height_rotated(p->rotation, lat, lon);
        low = heights[k] < low ? heights[k] : low;
        high = heights[k] > high ? heights[k] : high;
        analytic_color_rotated(p->rotation, lat, lon, rgb);
        for (int i = 0; i < 3; i++)
            pixels[3 * k + i] = (unsigned char)lrint(255 * rgb[p->grey ? 0 : i]);
    }
    bool color = id.layer == LAYER_COLOR;
    codec_blob body;
    status s =
        color ? codec_pixels_encode(pixels, 3, 100, &body) : codec_height_encode(heights, &body);
    if (!s) s = planet_writer_put(w, id, &body, color ? 0 : low, color ? 0 : high);
    codec_blob_deinit(&body);
    return s;
}

static status make_direct(const char *path, const analytic_params *p)
{
    struct planet_meta meta = {
        .name = "Analytic", .ellipsoid = p->ellipsoid, .synthesis_gain = p->synthesis_gain};
    struct planet_writer *w;
    unlink(path);
    status s = planet_writer_open(path, "analytic", false, &w);
    for (int layer = LAYER_HEIGHT; layer <= (p->color_zoom ? LAYER_COLOR : LAYER_HEIGHT); layer++)
        for (int z = 0; z <= p->zoom; z++)
            for (int row = 0; row < grid_rows(z); row++)
                for (int col = 0; !s && col < grid_cols(z, row); col++)
                    s = put_tile(w, p, (tile_id){(enum tile_layer)layer, z, row, col});
    if (!s) s = planet_writer_finish(w, &meta);
    planet_writer_close(&w);
    return s;
}

status analytic_planet_make_with(const char *path, const analytic_params *p)
{
    if (p->direct) return make_direct(path, p);
    char *rasters[2];
    if (asprintf(&rasters[0], "%s.tif", path) < 0) abort();
    if (asprintf(&rasters[1], "%s.color.tif", path) < 0) abort();
    status s = write_raster(rasters[0], p->zoom, p->rotation, false);
    if (!s && p->color_zoom) s = write_raster(rasters[1], p->color_zoom, p->rotation, true);
    import_source sources[2] = {{.layer = LAYER_HEIGHT, .path = rasters[0]},
                                {.layer = LAYER_COLOR, .path = rasters[1]}};
    import_params params = {.sources = sources,
                            .source_count = p->color_zoom ? 2 : 1,
                            .output = path,
                            .name = "Analytic",
                            .ellipsoid = p->ellipsoid,
                            .force = true};
    if (!s) s = import_run(&params);
    for (int i = 0; i < 2; i++) {
        unlink(rasters[i]);
        free(rasters[i]);
    }
    return s;
}

status analytic_planet_make_rotated(const char *path, int zoom, const dmat3 *rotation,
                                    geo_ellipsoid ellipsoid)
{
    const analytic_params params = {.zoom = zoom, .rotation = rotation, .ellipsoid = ellipsoid};
    return analytic_planet_make_with(path, &params);
}

status analytic_planet_make(const char *path, int zoom)
{
    return analytic_planet_make_with(path, &(analytic_params){.zoom = zoom});
}
