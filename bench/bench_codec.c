// What codecs make of the height tiles of a planet, all over the same tiles and in one run:
//   bench_codec PLANET MAX_ERROR [EVERY]
// PLANET: imported with --codec exact. Without loss, of heights rounded to their zoom's quantum:
// EXR ZIP, Zstandard of predicted and shuffled bytes, LERC + Zstandard, OpenJPEG 5/3, ours; ours
// once more over every tile of the planet. With loss: ours within MAX_ERROR, then JPEG 2000
// (OpenJPEG 9/7) and LERC + Zstandard at the same rms error. One line of JSON a codec: factor over
// 16 bits a sample, rms and greatest error, millions of samples a second of one core's time to
// encode and to decode. EVERY: of the finest zoom's tiles only every so many-th one with its
// ancestors.
#include <cpl_vsi.h>
#include <gdal.h>
#include <math.h>
#include <openjpeg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <zstd.h>

#include "planet/codec.h"
#include "planet/codec_bounded.h"
#include "planet/codec_grid.h"
#include "planet/codec_predict.h"
#include "planet/planet_file.h"
#include "planet/quantum.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE, MOST = 4096, ROOM = 1 << 21 };

// A codec: `data` holds what it makes. level: what it is told about quality.
struct codec {
    const char *name;
    size_t (*encode)(const float *heights, double level, unsigned char *data);
    void (*decode)(const unsigned char *data, size_t size, float *heights);
};

struct score {
    double bytes, encode_s, decode_s, square, worst;
    long samples;
};

struct tile {
    tile_id id;
    float *exact, *decoded; // as they are; as our bounded codec gives them
};

static struct tile tiles[MOST];
static int count;
static struct planet_file *file;

static double cpu_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void *need(void *p)
{
    if (!p) abort();
    return p;
}

static int exponent_of(tile_id id)
{
    return quantum_exponent(QUANTUM_AUTO, id.zoom, planet_file_meta(file)->ellipsoid.a);
}

static int find_tile(tile_id id)
{
    for (int i = 0; i < count; i++)
        if (tile_id_equal(tiles[i].id, id)) return i;
    return -1;
}

// Tiles of more than one value, of the finest zoom those with data in at least half: the others say
// little of a codec. A hole takes the height before it, for all codecs.
static bool take_tile(tile_id id, bool finest)
{
    if (find_tile(id) >= 0) return true;
    if (count == MOST) return false;
    float *h = need(malloc(2 * SAMPLES * sizeof *h)), low = INFINITY, high = -INFINITY, last = 0;
    bool good = planet_file_read_height(file, id, h) == OK;
    int holes = 0;
    for (int i = SAMPLES - 1; good && i >= 0; i--) last = isfinite(h[i]) ? h[i] : last;
    for (int i = 0; good && i < SAMPLES; i++) {
        holes += !isfinite(h[i]);
        last = h[i] = isfinite(h[i]) ? h[i] : last;
        low = fminf(low, h[i]);
        high = fmaxf(high, h[i]);
    }
    good = good && low < high && (!finest || 2 * holes <= SAMPLES);
    if (good) tiles[count++] = (struct tile){id, h, h + SAMPLES};
    else free(h);
    return good;
}

static int every = 1, seen;

static void visit(void *user, tile_id id)
{
    (void)user;
    if (id.zoom < planet_file_meta(file)->max_zoom[LAYER_HEIGHT] || seen++ % every) return;
    if (!take_tile(id, true)) return;
    while (id.zoom > 0) {
        id = tile_parent(id);
        take_tile(id, false);
    }
}

static int compare_zooms(const void *a, const void *b)
{
    const struct tile *x = a, *y = b;
    return x->id.zoom - y->id.zoom;
}

static void add_error(struct score *s, const float *want, const float *got)
{
    for (int i = 0; i < SAMPLES; i++) {
        double off = fabs((double)want[i] - (double)got[i]);
        s->square += off * off;
        s->worst = fmax(s->worst, off);
    }
    s->samples += SAMPLES;
}

static void print_score(const char *name, const struct score *s)
{
    double n = (double)s->samples;
    printf("{\"codec\": \"%s\", \"factor\": %.2f, \"bits\": %.3f, \"rms\": %.4f, \"max\": %.4f, "
           "\"encode\": %.1f, \"decode\": %.1f}\n",
           name, 2 * n / s->bytes, 8 * s->bytes / n, sqrt(s->square / n), s->worst,
           1e-6 * n / s->encode_s, 1e-6 * n / s->decode_s);
    fflush(stdout);
}

// One codec over all tiles. rounded: of heights on their zoom's grid.
static struct score run(const struct codec *c, double level, bool rounded)
{
    static unsigned char data[ROOM];
    static float want[SAMPLES], got[SAMPLES];
    static int32_t counts[SAMPLES];
    struct score s = {0};
    for (int i = 0; i < count; i++) {
        bool holes;
        memcpy(want, tiles[i].exact, sizeof want);
        if (rounded) {
            if (!grid_round(want, exponent_of(tiles[i].id), counts, &holes)) abort();
            grid_heights(counts, exponent_of(tiles[i].id), want);
        }
        double t0 = cpu_s();
        size_t size = c->encode(want, rounded ? exponent_of(tiles[i].id) : level, data);
        double t1 = cpu_s();
        c->decode(data, size, got);
        s.encode_s += t1 - t0;
        s.decode_s += cpu_s() - t1;
        s.bytes += (double)size;
        add_error(&s, want, got);
    }
    return s;
}

static size_t take_blob(status s, codec_blob *blob, unsigned char *data)
{
    if (s || blob->size > ROOM) abort();
    memcpy(data, blob->data, blob->size);
    size_t size = blob->size;
    codec_blob_deinit(blob);
    return size;
}

static size_t exr_encode(const float *heights, double exponent, unsigned char *data)
{
    (void)exponent;
    codec_blob blob;
    return take_blob(codec_height_encode(heights, &blob), &blob, data);
}

static size_t ours_encode(const float *heights, double exponent, unsigned char *data)
{
    static float copy[SAMPLES];
    codec_blob blob;
    memcpy(copy, heights, sizeof copy);
    return take_blob(codec_height_encode_grid(copy, (int)exponent, &blob), &blob, data);
}

static void any_decode(const unsigned char *data, size_t size, float *heights)
{
    if (codec_height_decode(data, size, heights)) abort();
}

// Zstandard: the difference to the plane through three neighbours, folded, in planes of bytes.
static int zstd_exponent;

static size_t zstd_encode(const float *heights, double exponent, unsigned char *data)
{
    static int32_t k[SAMPLES];
    static unsigned char planes[4 * SAMPLES];
    bool holes;
    zstd_exponent = (int)exponent;
    if (!grid_round(heights, zstd_exponent, k, &holes)) abort();
    for (int i = 0; i < SAMPLES; i++) {
        int y = i / TILE_SIZE, x = i % TILE_SIZE;
        int32_t p = !y  ? (x ? k[i - 1] : 0)
                    : x ? k[i - 1] + k[i - TILE_SIZE] - k[i - TILE_SIZE - 1]
                        : k[i - TILE_SIZE];
        uint32_t v = (uint32_t)(k[i] - p);
        v = v << 1 ^ (0u - (v >> 31));
        for (int b = 0; b < 4; b++) planes[b * SAMPLES + i] = (unsigned char)(v >> (8 * b));
    }
    size_t size = ZSTD_compress(data, ROOM, planes, sizeof planes, 9);
    if (ZSTD_isError(size)) abort();
    return size;
}

static void zstd_decode(const unsigned char *data, size_t size, float *heights)
{
    static int32_t k[SAMPLES];
    static unsigned char planes[4 * SAMPLES];
    if (ZSTD_decompress(planes, sizeof planes, data, size) != sizeof planes) abort();
    for (int i = 0; i < SAMPLES; i++) {
        int y = i / TILE_SIZE, x = i % TILE_SIZE;
        int32_t p = !y  ? (x ? k[i - 1] : 0)
                    : x ? k[i - 1] + k[i - TILE_SIZE] - k[i - TILE_SIZE - 1]
                        : k[i - TILE_SIZE];
        uint32_t v = 0;
        for (int b = 0; b < 4; b++) v |= (uint32_t)planes[b * SAMPLES + i] << (8 * b);
        k[i] = (int32_t)((uint32_t)p + (v >> 1 ^ (0u - (v & 1))));
    }
    grid_heights(k, zstd_exponent, heights);
}

// By a GDAL driver, in memory.
static size_t gdal_write(const char *driver, GDALDatasetH from, char **options, unsigned char *data)
{
    GDALDatasetH to = GDALCreateCopy(GDALGetDriverByName(driver), "/vsimem/codec", from, FALSE,
                                     options, NULL, NULL);
    if (!to) abort();
    GDALClose(to);
    vsi_l_offset size;
    unsigned char *bytes = VSIGetMemFileBuffer("/vsimem/codec", &size, FALSE);
    if (!bytes || size > ROOM) abort();
    memcpy(data, bytes, (size_t)size);
    return (size_t)size;
}

static GDALDatasetH memory_dataset(void *samples, GDALDataType type)
{
    char text[64], *at[] = {text, NULL};
    GDALDatasetH d =
        GDALCreate(GDALGetDriverByName("MEM"), "", TILE_SIZE, TILE_SIZE, 0, type, NULL);
    snprintf(text, sizeof text, "DATAPOINTER=%p", samples);
    if (!d || GDALAddBand(d, type, at) != CE_None) abort();
    return d;
}

static void gdal_read(const unsigned char *data, size_t size, const char *name, void *samples,
                      GDALDataType type)
{
    VSIFCloseL(VSIFileFromMemBuffer(name, (GByte *)data, size, FALSE));
    GDALDatasetH d = GDALOpen(name, GA_ReadOnly);
    if (!d || GDALRasterIO(GDALGetRasterBand(d, 1), GF_Read, 0, 0, TILE_SIZE, TILE_SIZE, samples,
                           TILE_SIZE, TILE_SIZE, type, 0, 0) != CE_None)
        abort();
    GDALClose(d);
    VSIUnlink(name);
}

// LERC + Zstandard in a TIFF of one block, floats; level: its greatest error.
static size_t lerc_encode(const float *heights, double level, unsigned char *data)
{
    char error[64];
    snprintf(error, sizeof error, "MAX_Z_ERROR=%.9g", level);
    char *options[] = {"COMPRESS=LERC_ZSTD", "TILED=YES", "BLOCKXSIZE=256",
                       "BLOCKYSIZE=256",     error,       NULL};
    GDALDatasetH d = memory_dataset((void *)heights, GDT_Float32);
    size_t size = gdal_write("GTiff", d, options, data);
    GDALClose(d);
    return size;
}

static void lerc_decode(const unsigned char *data, size_t size, float *heights)
{
    gdal_read(data, size, "/vsimem/codec.tif", heights, GDT_Float32);
}

static size_t lerc_encode_whole(const float *heights, double exponent, unsigned char *data)
{
    (void)exponent;
    return lerc_encode(heights, 0, data);
}

// JPEG 2000 by OpenJPEG itself, as GDAL's driver does it but for the quality, which it takes as a
// share of the bytes: here it is the PSNR of the wanted rms error. Whole quanta of 1/64 m (or the
// zoom's, without loss) above the lowest, in as many bits as they need.
struct jpeg {
    int exponent;
    double low;
};

static struct jpeg jpeg;

struct memory {
    unsigned char *data;
    size_t size, at;
};

static OPJ_SIZE_T read_memory(void *to, OPJ_SIZE_T size, void *user)
{
    struct memory *m = user;
    size_t left = m->size - m->at;
    if (!left) return (OPJ_SIZE_T)-1;
    size = size < left ? size : left;
    memcpy(to, m->data + m->at, size);
    m->at += size;
    return size;
}

static OPJ_SIZE_T write_memory(void *from, OPJ_SIZE_T size, void *user)
{
    struct memory *m = user;
    if (size > ROOM - m->at) return (OPJ_SIZE_T)-1;
    memcpy(m->data + m->at, from, size);
    m->at += size;
    m->size = m->at > m->size ? m->at : m->size;
    return size;
}

static OPJ_OFF_T skip_memory(OPJ_OFF_T by, void *user)
{
    ((struct memory *)user)->at += (size_t)by;
    return by;
}

static OPJ_BOOL seek_memory(OPJ_OFF_T at, void *user)
{
    ((struct memory *)user)->at = (size_t)at;
    return OPJ_TRUE;
}

static opj_stream_t *open_stream(struct memory *m, bool reads)
{
    opj_stream_t *s = need(opj_stream_create(1 << 16, reads));
    opj_stream_set_user_data(s, m, NULL);
    opj_stream_set_user_data_length(s, m->size);
    opj_stream_set_read_function(s, read_memory);
    opj_stream_set_write_function(s, write_memory);
    opj_stream_set_skip_function(s, skip_memory);
    opj_stream_set_seek_function(s, seek_memory);
    return s;
}

// rms 0: without loss, by the 5/3 wavelet; else by the 9/7.
static size_t jpeg_encode(const float *heights, int exponent, double rms, unsigned char *data)
{
    double quantum = ldexp(1, exponent);
    float low = INFINITY, high = -INFINITY;
    for (int i = 0; i < SAMPLES; i++) {
        low = fminf(low, heights[i]);
        high = fmaxf(high, heights[i]);
    }
    jpeg = (struct jpeg){exponent, quantum * rint((double)low / quantum)};
    int bits = ilogb(((double)high - (double)low) / quantum + 1) + 1;
    opj_image_cmptparm_t p = {
        .dx = 1, .dy = 1, .w = TILE_SIZE, .h = TILE_SIZE, .prec = (OPJ_UINT32)bits};
    opj_image_t *image = need(opj_image_create(1, &p, OPJ_CLRSPC_GRAY));
    image->x1 = image->y1 = TILE_SIZE;
    for (int i = 0; i < SAMPLES; i++)
        image->comps[0].data[i] = (OPJ_INT32)rint(((double)heights[i] - jpeg.low) / quantum);
    opj_cparameters_t c;
    opj_set_default_encoder_parameters(&c);
    c.irreversible = rms > 0;
    c.tcp_numlayers = 1;
    if (rms > 0) {
        c.cp_fixed_quality = 1;
        c.tcp_distoratio[0] = (float)(20 * log10((ldexp(1, bits) - 1) * quantum / rms));
    } else {
        c.cp_disto_alloc = 1;
    }
    struct memory m = {.data = data};
    opj_codec_t *codec = need(opj_create_compress(OPJ_CODEC_J2K));
    opj_stream_t *stream = open_stream(&m, false);
    if (!opj_setup_encoder(codec, &c, image) || !opj_start_compress(codec, image, stream) ||
        !opj_encode(codec, stream) || !opj_end_compress(codec, stream))
        abort();
    opj_stream_destroy(stream);
    opj_destroy_codec(codec);
    opj_image_destroy(image);
    return m.size;
}

static void jpeg_decode(const unsigned char *data, size_t size, float *heights)
{
    struct memory m = {.data = (unsigned char *)data, .size = size};
    opj_dparameters_t p;
    opj_set_default_decoder_parameters(&p);
    opj_codec_t *codec = need(opj_create_decompress(OPJ_CODEC_J2K));
    opj_stream_t *stream = open_stream(&m, true);
    opj_image_t *image = NULL;
    if (!opj_setup_decoder(codec, &p) || !opj_read_header(stream, codec, &image) ||
        !opj_decode(codec, stream, image))
        abort();
    for (int i = 0; i < SAMPLES; i++)
        heights[i] = (float)(jpeg.low + ldexp(image->comps[0].data[i], jpeg.exponent));
    opj_image_destroy(image);
    opj_stream_destroy(stream);
    opj_destroy_codec(codec);
}

static size_t jpeg_encode_whole(const float *heights, double exponent, unsigned char *data)
{
    return jpeg_encode(heights, (int)exponent, 0, data);
}

static size_t jpeg_encode_rough(const float *heights, double rms, unsigned char *data)
{
    return jpeg_encode(heights, -6, rms, data);
}

// Ours without loss, over every tile of the planet: holes and tiles of one value too.
static void add_every(void *user, tile_id id)
{
    static float want[SAMPLES], got[SAMPLES];
    struct score *s = user;
    codec_blob body;
    if (planet_file_read_height(file, id, want)) abort();
    double t0 = cpu_s();
    if (codec_height_encode_grid(want, exponent_of(id), &body)) abort();
    double t1 = cpu_s();
    if (codec_height_decode(body.data, body.size, got)) abort();
    s->decode_s += cpu_s() - t1;
    s->encode_s += t1 - t0;
    s->bytes += (double)body.size;
    s->samples += SAMPLES;
    for (int i = 0; i < SAMPLES; i++)
        if (!(want[i] == got[i] || (isnan(want[i]) && isnan(got[i])))) abort();
    codec_blob_deinit(&body);
}

static struct score run_bounded(double max_error)
{
    static float want[SAMPLES], predicted[SAMPLES], got[SAMPLES];
    static int32_t counts[SAMPLES];
    struct score s = {0};
    int exponent = bounded_exponent(max_error);
    for (int i = 0; i < count; i++) {
        struct tile *t = &tiles[i];
        int above = t->id.zoom ? find_tile(tile_parent(t->id)) : -1;
        bool holes;
        codec_blob body;
        double t0 = cpu_s();
        if (!grid_round(t->exact, exponent, counts, &holes)) abort();
        grid_heights(counts, exponent, want);
        predict_tile(t->id, above < 0 ? NULL : tiles[above].decoded, predicted);
        if (bounded_encode(want, predicted, max_error, &body, t->decoded)) abort();
        double t1 = cpu_s();
        predict_tile(t->id, above < 0 ? NULL : tiles[above].decoded, predicted);
        status st = bounded_is_body(body.data, body.size)
                        ? bounded_decode(body.data, body.size, predicted, got)
                        : codec_height_decode(body.data, body.size, got);
        s.decode_s += cpu_s() - t1;
        s.encode_s += t1 - t0;
        s.bytes += (double)body.size;
        if (st || memcmp(got, t->decoded, sizeof got)) abort();
        add_error(&s, t->exact, got);
        codec_blob_deinit(&body);
    }
    if (s.worst > max_error) abort();
    return s;
}

static double rms_of(const struct score *s)
{
    return sqrt(s->square / (double)s->samples);
}

// A codec at a wanted rms error: what it is told is nearly in proportion to that.
static void print_at_rms(const struct codec *c, double level, double rms)
{
    struct score s = run(c, level, false);
    for (int i = 0; i < 5 && fabs(rms_of(&s) / rms - 1) > 0.01; i++) {
        level *= rms / rms_of(&s);
        s = run(c, level, false);
    }
    print_score(c->name, &s);
}

static const struct codec whole[] = {{"EXR ZIP", exr_encode, any_decode},
                                     {"Zstandard", zstd_encode, zstd_decode},
                                     {"LERC + Zstandard", lerc_encode_whole, lerc_decode},
                                     {"OpenJPEG 5/3", jpeg_encode_whole, jpeg_decode},
                                     {"lossless", ours_encode, any_decode}};
static const struct codec jpeg_rough = {"OpenJPEG 9/7", jpeg_encode_rough, jpeg_decode};
static const struct codec lerc_rough = {"LERC + Zstandard", lerc_encode, lerc_decode};

int main(int argc, char **argv)
{
    if (argc != 3 && argc != 4) {
        fprintf(stderr, "usage: bench_codec PLANET MAX_ERROR [EVERY]\n");
        return 2;
    }
    double max_error = atof(argv[2]);
    if (argc == 4) every = atoi(argv[3]);
    if (every < 1 || !(max_error >= BOUNDED_MIN_ERROR && max_error <= BOUNDED_MAX_ERROR)) return 2;
    GDALAllRegister();
    if (planet_file_open(argv[1], &file) || planet_file_list(file, LAYER_HEIGHT, visit, NULL))
        return 1;
    qsort(tiles, (size_t)count, sizeof *tiles, compare_zooms);
    printf("{\"planet\": \"%s\", \"max_error\": %g, \"tiles\": %d, \"finest_quantum\": %g}\n",
           argv[1], max_error, count, count ? ldexp(1, exponent_of(tiles[count - 1].id)) : 0);
    if (!count) return 1;
    for (size_t i = 0; i < sizeof whole / sizeof *whole; i++) {
        struct score s = run(&whole[i], 0, true);
        print_score(whole[i].name, &s);
        if (s.worst > 0) return 1; // fast and wrong
    }
    struct score all = {0};
    if (planet_file_list(file, LAYER_HEIGHT, add_every, &all)) return 1;
    print_score("lossless, every tile", &all);
    struct score ours = run_bounded(max_error);
    print_score("bounded", &ours);
    print_at_rms(&jpeg_rough, rms_of(&ours), rms_of(&ours));
    print_at_rms(&lerc_rough, rms_of(&ours) * sqrt(3), rms_of(&ours));
    planet_file_close(&file);
    return 0;
}
