#include "planet/circle.h"

#include <gdal.h>
#include <gdal_vrt.h>
#include <math.h>
#include <ogr_srs_api.h>

enum { BEYOND = 4 }; // columns

// Columns of `from`, round and round, beginning with its column -`first`.
static void put_around(GDALRasterBandH to, GDALRasterBandH from, int first)
{
    int width = GDALGetRasterBandXSize(from), height = GDALGetRasterBandYSize(from),
        room = GDALGetRasterBandXSize(to);
    for (int at = first % width - width; at < room; at += width) {
        int cut = at < 0 ? -at : 0, count = (at + width < room ? width : room - at) - cut;
        if (count <= 0) continue;
        VRTAddSimpleSource((VRTSourcedRasterBandH)to, from, cut, 0, count, height, at + cut, 0,
                           count, height, NULL, VRT_NODATA_UNSET);
    }
}

static void copy_band(GDALDatasetH to, int number, GDALRasterBandH from, int first)
{
    GDALAddBand(to, GDALGetRasterDataType(from), NULL);
    GDALRasterBandH band = GDALGetRasterBand(to, number);
    int known;
    double none = GDALGetRasterNoDataValue(from, &known);
    if (known) GDALSetRasterNoDataValue(band, none);
    GDALSetRasterColorInterpretation(band, GDALGetRasterColorInterpretation(from));
    put_around(band, from, first);
}

static void copy_mask(GDALDatasetH to, GDALRasterBandH from, int first)
{
    int kind = GDALGetMaskFlags(from);
    if (!(kind & GMF_PER_DATASET) || kind & GMF_ALPHA) return;
    if (GDALCreateDatasetMaskBand(to, GMF_PER_DATASET) == CE_None)
        put_around(GDALGetMaskBand(GDALGetRasterBand(to, 1)), GDALGetMaskBand(from), first);
}

void *circle_close(void *dataset)
{
    double g[6];
    OGRSpatialReferenceH srs = GDALGetSpatialRef(dataset);
    int width = GDALGetRasterXSize(dataset), height = GDALGetRasterYSize(dataset);
    if (!srs || !OSRIsGeographic(srs) || GDALGetGeoTransform(dataset, g) != CE_None || g[2] != 0 ||
        fabs(g[1] * width - 360) > 0.01 * g[1])
        return NULL;
    // The raster's first column is so many to the right of the first one here.
    int first = (int)floor((g[0] + 180) / g[1] + 1e-6) + BEYOND;
    g[0] -= first * g[1];
    g[3] -= first * g[4];
    GDALDatasetH closed = VRTCreate(width + 2 * BEYOND, height);
    GDALSetGeoTransform(closed, g);
    GDALSetSpatialRef(closed, srs);
    for (int i = 1; i <= GDALGetRasterCount(dataset); i++)
        copy_band(closed, i, GDALGetRasterBand(dataset, i), first);
    copy_mask(closed, GDALGetRasterBand(dataset, 1), first);
    return closed;
}
