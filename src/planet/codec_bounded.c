// The body: a head of 32 bytes, the holes, the picture, the corrections. The head, little-endian:
// "PGB1", the quantum's exponent, whether the corrections are compressed, two bytes of zero, then
// four bytes each: the step of a correction in quanta, the size of the holes, of the picture (0:
// none) and of the corrections, the XXH32 of the counts decoded, four bytes of zero.
#include "planet/codec_bounded.h"

#include <endian.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>
#include <zstd.h>

#include "planet/codec_grid.h"
#include "planet/codec_uniform.h"
#include "planet/codec_wavelet.h"
#include "planet/upsample.h"

enum {
    SAMPLES = TILE_SIZE * TILE_SIZE,
    HEAD = 32,
    // A gap of 65535 in steps of 255 and a correction of five bytes, or one byte of gap each.
    MAX_CORRECTIONS = SAMPLES * 6 + 512,
    LEVEL = 9
};

// The picture's rms error as a share of the bound. At a quarter 0.02 to 0.4 % of the samples need a
// correction, and the whole is smallest at equal rms (bench/RESULTS-codec.md).
#define PICTURE_SHARE 0.25

static const char magic[4] = {'P', 'G', 'B', '1'};

struct head {
    int exponent;
    bool packed;
    uint32_t step, holes, picture, corrections, check;
};

int bounded_exponent(double max_error)
{
    int exponent;
    frexp(max_error / 16, &exponent);
    return exponent - 1;
}

// The prediction

// A gap takes the height before it, in the order of rows; the first ones that of the first there
// is.
static void fill_gaps(float *heights)
{
    float last = 0;
    for (int i = 0; i < SAMPLES; i++)
        if (isfinite(heights[i])) {
            last = heights[i];
            break;
        }
    for (int i = 0; i < SAMPLES; i++) {
        if (isfinite(heights[i])) last = heights[i];
        else heights[i] = last;
    }
}

// A sample of the parent tile; beyond its border on the straight line through the last two.
static float beyond(const float *parent, int64_t row, int64_t col)
{
    const int64_t last = TILE_SIZE - 1;
    int64_t y = row < 0 ? 0 : row > last ? last : row, x = col < 0 ? 0 : col > last ? last : col;
    float v = parent[y * TILE_SIZE + x], h = v;
    if (x != col) {
        int64_t inner = x == 0 ? 1 : last - 1;
        h += (float)(x > col ? x - col : col - x) * (v - parent[y * TILE_SIZE + inner]);
    }
    if (y != row) {
        int64_t inner = y == 0 ? 1 : last - 1;
        h += (float)(y > row ? y - row : row - y) * (v - parent[inner * TILE_SIZE + x]);
    }
    return h;
}

void bounded_predict(tile_id id, const float *parent, float *predicted)
{
    memset(predicted, 0, SAMPLES * sizeof *predicted);
    if (!parent) return;
    float *whole = malloc(SAMPLES * sizeof *whole);
    region child = region_of_tile(id, 1, predicted), around = region_parent(&child);
    around.data = malloc((size_t)around.rows * (size_t)around.stride * sizeof *around.data);
    if (!whole || !around.data) abort();
    memcpy(whole, parent, SAMPLES * sizeof *whole);
    fill_gaps(whole);
    tile_id above = tile_parent(id);
    int64_t north = (int64_t)TILE_SIZE * above.row, west = (int64_t)TILE_SIZE * above.col;
    for (int y = 0; y < around.rows; y++)
        for (int x = 0; x < around.cols; x++)
            around.data[y * around.stride + x] =
                beyond(whole, around.row + y - north, around.col + x - west);
    bool flat[TILE_SIZE];
    for (int row = 0; row < TILE_SIZE; row++)
        upsample_child_row(&around, &child, row, predicted + (size_t)row * TILE_SIZE, flat);
    free(around.data);
    free(whole);
}

// The prediction in whole quanta, within the grid.
static void count_prediction(const float *predicted, int exponent, int32_t *counts)
{
    const float scale = ldexpf(1, -exponent), limit = GRID_COUNT_LIMIT - 1;
    for (int i = 0; i < SAMPLES; i++) {
        float v = predicted[i] * scale;
        v = v < limit ? v : limit; // NaN too
        counts[i] = grid_nearest(v > -limit ? v : -limit);
    }
}

// The corrections: for each a gap (bytes of 255 and a last one below), then the count of steps,
// folded to 0, -1, 1, ... in bytes of seven bits, the lowest first, each but the last with the
// eighth set.

static size_t write_corrections(const int32_t *steps, unsigned char *out)
{
    size_t n = 0;
    int gap = 0;
    for (int i = 0; i < SAMPLES; i++) {
        if (steps[i] == 0) {
            gap++;
            continue;
        }
        for (; gap >= 255; gap -= 255) out[n++] = 255;
        out[n++] = (unsigned char)gap;
        gap = 0;
        uint32_t v = (uint32_t)steps[i] << 1 ^ (0u - ((uint32_t)steps[i] >> 31));
        for (; v >= 128; v >>= 7) out[n++] = (unsigned char)(v | 128);
        out[n++] = (unsigned char)v;
    }
    return n;
}

// Adds what the corrections say. False when they are none, or run out of the tile.
static bool add_corrections(const unsigned char *in, size_t size, uint32_t step, int32_t *counts)
{
    size_t n = 0, at = 0;
    while (n < size) {
        unsigned char gap;
        do {
            gap = in[n++];
            at += gap;
        } while (gap == 255 && n < size);
        if (gap == 255 || at >= SAMPLES) return false;
        uint32_t v = 0;
        for (int shift = 0;; shift += 7) {
            if (n >= size || shift > 28) return false;
            v |= (uint32_t)(in[n] & 127) << shift;
            if (!(in[n++] & 128)) break;
        }
        counts[at] = (int32_t)((uint32_t)counts[at] + (v >> 1 ^ (0u - (v & 1))) * step);
        at++;
    }
    return true;
}

static uint32_t checksum(const int32_t *counts)
{
    uint32_t *bytes = malloc(SAMPLES * sizeof *bytes);
    if (!bytes) abort();
    for (int i = 0; i < SAMPLES; i++) bytes[i] = htole32((uint32_t)counts[i]);
    uint32_t sum = XXH32(bytes, SAMPLES * sizeof *bytes, 0);
    free(bytes);
    return sum;
}

static void write_word(unsigned char *out, uint32_t v)
{
    for (int i = 0; i < 4; i++) out[i] = (unsigned char)(v >> (8 * i));
}

static uint32_t read_word(const unsigned char *in)
{
    return (uint32_t)in[0] | (uint32_t)in[1] << 8 | (uint32_t)in[2] << 16 | (uint32_t)in[3] << 24;
}

static void write_head(const struct head *h, unsigned char out[HEAD])
{
    memset(out, 0, HEAD);
    memcpy(out, magic, sizeof magic);
    out[4] = (unsigned char)(signed char)h->exponent;
    out[5] = h->packed;
    const uint32_t words[] = {h->step, h->holes, h->picture, h->corrections, h->check};
    for (int i = 0; i < 5; i++) write_word(out + 8 + 4 * i, words[i]);
}

static bool read_head(const unsigned char *in, size_t size, struct head *h)
{
    if (size < HEAD || in[5] > 1 || in[6] || in[7] || read_word(in + 28)) return false;
    *h = (struct head){.exponent = (signed char)in[4],
                       .packed = in[5],
                       .step = read_word(in + 8),
                       .holes = read_word(in + 12),
                       .picture = read_word(in + 16),
                       .corrections = read_word(in + 20),
                       .check = read_word(in + 24)};
    uint64_t all = (uint64_t)HEAD + h->holes + h->picture + h->corrections;
    return all == size && h->exponent >= GRID_EXPONENT_MIN && h->exponent <= GRID_EXPONENT_MAX;
}

// The encoder

// What is made on the way to a body.
struct work {
    int32_t want[SAMPLES], base[SAMPLES], rest[SAMPLES], made[SAMPLES];
    unsigned char raw[MAX_CORRECTIONS], small[MAX_CORRECTIONS + 1024];
    codec_blob holes, picture;
    struct head head;
};

static double rms_of(const int32_t *values)
{
    double sum = 0;
    for (int i = 0; i < SAMPLES; i++) sum += (double)values[i] * values[i];
    return sqrt(sum / SAMPLES);
}

// The picture of what is missing, and what it gives, in w->made.
static status make_picture(struct work *w, double rms)
{
    memset(w->made, 0, sizeof w->made);
    if (rms_of(w->rest) <= rms) return OK;
    status s = wavelet_encode(w->rest, rms, &w->picture);
    return s ? s : wavelet_decode(w->picture.data, w->picture.size, w->made);
}

// Whole steps where the picture is farther off than half a step; then w->made holds the counts.
static size_t correct(struct work *w, const float *samples)
{
    const int32_t step = (int32_t)w->head.step, half = step / 2;
    for (int i = 0; i < SAMPLES; i++) {
        int32_t off = isfinite(samples[i]) ? w->rest[i] - w->made[i] : 0;
        int32_t steps = off > half ? (off + half) / step : off < -half ? -((half - off) / step) : 0;
        w->made[i] += w->base[i] + steps * step;
        w->rest[i] = steps;
    }
    return write_corrections(w->rest, w->raw);
}

static status assemble(struct work *w, size_t corrections, codec_blob *out)
{
    size_t small = ZSTD_compress(w->small, sizeof w->small, w->raw, corrections, LEVEL);
    w->head.packed = !ZSTD_isError(small) && small < corrections;
    w->head.holes = (uint32_t)w->holes.size;
    w->head.picture = (uint32_t)w->picture.size;
    w->head.corrections = (uint32_t)(w->head.packed ? small : corrections);
    w->head.check = checksum(w->made);
    size_t size = HEAD + w->holes.size + w->picture.size + w->head.corrections;
    unsigned char *data = malloc(size), *at = data + HEAD;
    if (!data) return ERR_MEMORY;
    write_head(&w->head, data);
    if (w->holes.size) memcpy(at, w->holes.data, w->holes.size);
    at += w->holes.size;
    if (w->picture.size) memcpy(at, w->picture.data, w->picture.size);
    at += w->picture.size;
    if (w->head.corrections) memcpy(at, w->head.packed ? w->small : w->raw, w->head.corrections);
    *out = (codec_blob){data, size};
    return OK;
}

static bool is_within(const float *samples, const float *decoded, double bound)
{
    int bad = 0;
    for (int i = 0; i < SAMPLES; i++)
        bad += isfinite(samples[i]) ? !(fabs((double)decoded[i] - (double)samples[i]) <= bound)
                                    : !isnan(decoded[i]);
    return bad == 0;
}

static void give_heights(const struct work *w, const float *samples, float *decoded)
{
    grid_heights(w->made, w->head.exponent, decoded);
    for (int i = 0; i < SAMPLES; i++)
        if (!isfinite(samples[i])) decoded[i] = NAN;
}

// ERR_UNSUPPORTED when the tile cannot be coded so within the bound.
static status encode_residual(struct work *w, const float *samples, const float *predicted,
                              double max_error, bool holes, codec_blob *out, float *decoded)
{
    double quantum = ldexp(1, w->head.exponent), bound = max_error - quantum / 2;
    w->head.step = 2 * (uint32_t)floor(bound / quantum) + 1;
    count_prediction(predicted, w->head.exponent, w->base);
    for (int i = 0; i < SAMPLES; i++)
        w->rest[i] = isfinite(samples[i]) ? w->want[i] - w->base[i] : 0;
    status s = holes ? holes_encode(samples, &w->holes) : OK;
    if (!s) s = make_picture(w, PICTURE_SHARE * max_error / quantum);
    if (!s) s = assemble(w, correct(w, samples), out);
    if (s) return s;
    give_heights(w, samples, decoded);
    if (is_within(samples, decoded, bound)) return OK;
    codec_blob_deinit(out);
    return ERR_UNSUPPORTED;
}

status bounded_encode(const float *samples, const float *predicted, double max_error,
                      codec_blob *out, float *decoded)
{
    *out = (codec_blob){0};
    memcpy(decoded, samples, SAMPLES * sizeof *decoded);
    if (uniform_encode_height(samples, out)) return OK;
    struct work *w = calloc(1, sizeof *w);
    float *lossy = malloc(SAMPLES * sizeof *lossy);
    bool holes, fits;
    codec_blob plain = {0}, body = {0};
    status s = w && lossy ? OK : ERR_MEMORY;
    if (!s) {
        w->head.exponent = bounded_exponent(max_error);
        fits = grid_round(samples, w->head.exponent, w->want, &holes);
        s = fits ? grid_encode(w->want, w->head.exponent, holes ? samples : NULL, &plain)
                 : codec_height_encode(samples, &plain);
        if (!s && fits) s = encode_residual(w, samples, predicted, max_error, holes, &body, lossy);
        if (s == ERR_UNSUPPORTED) s = OK;
    }
    bool rough = !s && body.size && body.size < plain.size;
    if (rough) memcpy(decoded, lossy, SAMPLES * sizeof *decoded);
    if (!s) *out = rough ? body : plain;
    if (s || !rough) codec_blob_deinit(&body);
    if (s || rough) codec_blob_deinit(&plain);
    if (w) codec_blob_deinit(&w->holes);
    if (w) codec_blob_deinit(&w->picture);
    free(lossy);
    free(w);
    return s;
}

// The decoder

bool bounded_is_body(const void *data, size_t size)
{
    return size >= sizeof magic && memcmp(data, magic, sizeof magic) == 0;
}

static status unpack_corrections(const struct head *h, const unsigned char *data, int32_t *counts)
{
    if (!h->packed) return add_corrections(data, h->corrections, h->step, counts) ? OK : ERR_FORMAT;
    unsigned char *raw = malloc(MAX_CORRECTIONS);
    if (!raw) return ERR_MEMORY;
    size_t size = ZSTD_decompress(raw, MAX_CORRECTIONS, data, h->corrections);
    bool good = !ZSTD_isError(size) && add_corrections(raw, size, h->step, counts);
    free(raw);
    return good ? OK : ERR_FORMAT;
}

status bounded_decode(const void *data, size_t size, const float *predicted, float *samples)
{
    struct head h;
    if (!read_head(data, size, &h)) return ERR_FORMAT;
    const unsigned char *holes = (const unsigned char *)data + HEAD, *picture = holes + h.holes;
    int32_t *counts = malloc(2 * SAMPLES * sizeof *counts);
    if (!counts) return ERR_MEMORY;
    int32_t *made = counts + SAMPLES;
    count_prediction(predicted, h.exponent, counts);
    status s = OK;
    if (h.picture) s = wavelet_decode(picture, h.picture, made);
    for (int i = 0; !s && h.picture && i < SAMPLES; i++)
        counts[i] = (int32_t)((uint32_t)counts[i] + (uint32_t)made[i]);
    if (!s) s = unpack_corrections(&h, picture + h.picture, counts);
    if (!s && checksum(counts) != h.check) s = ERR_FORMAT;
    if (!s) grid_heights(counts, h.exponent, samples);
    if (!s && h.holes) s = holes_decode(holes, h.holes, samples);
    free(counts);
    return s;
}
