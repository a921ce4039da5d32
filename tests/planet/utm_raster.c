#include "utm_raster.h"

#include <gdal.h>
#include <math.h>
#include <ogr_srs_api.h>
#include <stdlib.h>

// Columns and rows count from the corner, eastwards and northwards.
static double sample(int col, int row)
{
    return 400 + 120 * sin(0.05 * col + 0.3) * cos(0.04 * row) + 20 * sin(0.11 * row + 0.08 * col);
}

double utm_raster_height(double east, double north)
{
    double x = east / UTM_RASTER_STEP - 0.5, y = north / UTM_RASTER_STEP - 0.5;
    int col = (int)floor(x), row = (int)floor(y);
    double u = x - col, v = y - row;
    return (1 - v) * ((1 - u) * sample(col, row) + u * sample(col + 1, row)) +
           v * ((1 - u) * sample(col, row + 1) + u * sample(col + 1, row + 1));
}

static void place(GDALDatasetH d, int width, int height)
{
    double west = 500000 - UTM_RASTER_STEP * (width / 2),
           top = 4982950.4 + UTM_RASTER_STEP * (height / 2);
    double transform[6] = {west, UTM_RASTER_STEP, 0, top, 0, -UTM_RASTER_STEP};
    OGRSpatialReferenceH srs = OSRNewSpatialReference(NULL);
    OSRImportFromEPSG(srs, 32632);
    GDALSetGeoTransform(d, transform);
    GDALSetSpatialRef(d, srs);
    OSRDestroySpatialReference(srs);
}

status utm_raster_write(const char *path, int width, int height)
{
    GDALAllRegister();
    GDALDatasetH d =
        GDALCreate(GDALGetDriverByName("GTiff"), path, width, height, 1, GDT_Float32, NULL);
    float *line = malloc((size_t)width * sizeof *line);
    CPLErr error = d && line ? CE_None : CE_Failure;
    if (!error) place(d, width, height);
    for (int y = 0; y < height && !error; y++) {
        for (int x = 0; x < width; x++) line[x] = (float)sample(x - width / 2, height / 2 - 1 - y);
        error = GDALRasterIO(GDALGetRasterBand(d, 1), GF_Write, 0, y, width, 1, line, width, 1,
                             GDT_Float32, 0, 0);
    }
    free(line);
    if (d) GDALClose(d);
    return error ? ERR_IO : OK;
}
