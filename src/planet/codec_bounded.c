// The body: a head of 24 bytes, the holes, then as codec_symbols.h writes them the coefficients of
// what is missing (codec_bands.h) and the corrections. The head, little-endian: "PGB2"; a
// byte each: the quantum's exponent, the greatest error in quanta, the two shifts and the empty
// levels of codec_bands.h, zero; two bytes each: the step of the coefficients in eighths of a
// quantum, the size of the holes, the number of corrections; four bytes each: where the plain bits
// begin among the symbols, the XXH32 of the counts decoded.
#include "planet/codec_bounded.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "planet/codec_bands.h"
#include "planet/codec_bounded1.h"
#include "planet/codec_grid.h"
#include "planet/codec_predict.h"
#include "planet/codec_uniform.h"
#include "planet/wavelet.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE, HEAD = 24, MOST_CORRECTIONS = 0xffff };

static const char magic[4] = {'P', 'G', 'B', '2'};

// The coefficients' rms error as shares of the bound, as it were if all were even fields. A tile is
// coded at the middle one and, as many samples need a correction then or few, at one more.
static const double shares[] = {0.35, 0.5, 0.7};
enum { MANY_CORRECTIONS = SAMPLES / 50 };

struct head {
    int exponent, reach;
    struct bands_scale scale;
    uint32_t holes, corrections, bits_at, check;
};

int bounded_exponent(double max_error)
{
    int exponent;
    frexp(max_error / 16, &exponent);
    return exponent - 1;
}

static void write_number(unsigned char *out, int bytes, uint32_t v)
{
    for (int i = 0; i < bytes; i++) out[i] = (unsigned char)(v >> (8 * i));
}

static uint32_t read_number(const unsigned char *in, int bytes)
{
    uint32_t v = 0;
    for (int i = bytes - 1; i >= 0; i--) v = v << 8 | in[i];
    return v;
}

static void write_head(const struct head *h, unsigned char out[HEAD])
{
    memcpy(out, magic, sizeof magic);
    out[4] = (unsigned char)(signed char)h->exponent;
    out[5] = (unsigned char)h->reach;
    out[6] = (unsigned char)h->scale.shift[0];
    out[7] = (unsigned char)h->scale.shift[1];
    out[8] = h->scale.empty;
    out[9] = 0;
    write_number(out + 10, 2, (uint32_t)(h->scale.step * 8));
    write_number(out + 12, 2, h->holes);
    write_number(out + 14, 2, h->corrections);
    write_number(out + 16, 4, h->bits_at);
    write_number(out + 20, 4, h->check);
}

static bool read_head(const unsigned char *in, size_t size, struct head *h)
{
    if (size < HEAD) return false;
    *h = (struct head){.exponent = (signed char)in[4],
                       .reach = in[5],
                       .scale = {.step = (float)read_number(in + 10, 2) / 8,
                                 .shift = {(signed char)in[6], (signed char)in[7]},
                                 .empty = in[8]},
                       .holes = read_number(in + 12, 2),
                       .corrections = read_number(in + 14, 2),
                       .bits_at = read_number(in + 16, 4),
                       .check = read_number(in + 20, 4)};
    return in[9] == 0 && h->exponent >= GRID_EXPONENT_MIN && h->exponent <= GRID_EXPONENT_MAX &&
           h->scale.empty <= WAVELET_LEVELS && size - HEAD >= h->holes &&
           size - HEAD - h->holes >= h->bits_at;
}

// Corrections

// They go along the Z-order curve, so that those of one place stand together: for each the samples
// passed over since the last, as a symbol for their power of two and plain bits; then one symbol,
// twice the further steps down or up and whether it is up. The table of a gap is chosen by
// whether the one before was long, that of a correction, after a short gap, by the one before.
struct corrections {
    struct symbol_table gaps[2], steps[3];
    int long_gap, context;
};

enum { SHORT_GAP = 8, MOST_STEPS = 7 };

static void corrections_init(struct corrections *c)
{
    double even[SYMBOL_COUNT], few[SYMBOL_COUNT];
    for (int i = 0; i < SYMBOL_COUNT; i++) {
        even[i] = 1;
        few[i] = i < 2 ? 1 : 0.01;
    }
    for (int i = 0; i < 2; i++) symbol_table_init(&c->gaps[i], even);
    for (int i = 0; i < 3; i++) symbol_table_init(&c->steps[i], few);
    c->long_gap = 1;
    c->context = 0;
}

static void corrections_follow(struct corrections *c, int gap, int symbol)
{
    c->long_gap = gap >= SHORT_GAP;
    c->context = 1 + (symbol & 1);
}

// Place of the i-th sample along the curve.
static int place_of(uint32_t i)
{
    uint32_t x = i & 0x5555, y = i >> 1 & 0x5555;
    x = (x | x >> 1) & 0x3333;
    y = (y | y >> 1) & 0x3333;
    x = (x | x >> 2) & 0x0f0f;
    y = (y | y >> 2) & 0x0f0f;
    x = (x | x >> 4) & 0x00ff;
    y = (y | y >> 4) & 0x00ff;
    return (int)(y * TILE_SIZE + x);
}

// What a correction adds, in quanta: the first step brings most of what is just beyond the bound
// near to 0, each further one is twice the bound.
static int32_t correction(int reach, int symbol)
{
    int32_t amount = reach + reach / 8 + 1 + (symbol >> 1) * (2 * reach + 1);
    return symbol & 1 ? amount : -amount;
}

static void put_correction(struct corrections *c, int gap, int symbol, struct symbol_writer *w)
{
    int power = 0;
    while (gap >> power > 1) power++;
    symbol_put(w, &c->gaps[c->long_gap], power);
    symbol_put_bits(w, (uint32_t)gap, power ? power : 1);
    symbol_put(w, &c->steps[gap < SHORT_GAP ? c->context : 0], symbol);
    corrections_follow(c, gap, symbol);
}

// Adds the corrections to counts. False when they run out of the tile.
static bool get_corrections(const struct head *h, struct symbol_reader *r, int32_t *counts)
{
    struct corrections c;
    uint32_t at = 0;
    corrections_init(&c);
    for (uint32_t k = 0; k < h->corrections; k++, at++) {
        int power = symbol_get(r, &c.gaps[c.long_gap]);
        int gap = power ? 1 << power | (int)symbol_get_bits(r, power) : (int)symbol_get_bits(r, 1);
        int symbol = symbol_get(r, &c.steps[gap < SHORT_GAP ? c.context : 0]);
        at += (uint32_t)gap;
        if (at >= SAMPLES) return false;
        counts[place_of(at)] += correction(h->reach, symbol);
        corrections_follow(&c, gap, symbol);
    }
    return true;
}

// The encoder

// What is made on the way to a body.
struct work {
    int32_t want[SAMPLES], base[SAMPLES], made[SAMPLES];
    float rest[SAMPLES], coefficients[SAMPLES], back[SAMPLES], room[SAMPLES];
    struct symbol_writer *writer;
    codec_blob holes;
    struct head head;
};

// The prediction and what was missing, in whole quanta.
static void add_up(const int32_t *base, const float *rest, int32_t *counts)
{
    const float limit = 2 * GRID_COUNT_LIMIT;
    for (int i = 0; i < SAMPLES; i++) {
        float v = rest[i] < limit ? rest[i] : limit; // NaN too
        counts[i] = base[i] + grid_nearest(v > -limit ? v : -limit);
    }
}

// Corrects w->made where it is out of reach. ERR_UNSUPPORTED when no correction reaches.
static status correct(struct work *w, const float *samples)
{
    struct corrections c;
    const int reach = w->head.reach;
    int gap = 0;
    corrections_init(&c);
    w->head.corrections = 0;
    for (uint32_t i = 0; i < SAMPLES; i++) {
        int at = place_of(i);
        int32_t off = isfinite(samples[at]) ? w->want[at] - w->made[at] : 0;
        if (off <= reach && off >= -reach) {
            gap++;
            continue;
        }
        int symbol = off > 0;
        while (abs(off - correction(reach, symbol)) > reach && symbol < 2 * MOST_STEPS) symbol += 2;
        w->made[at] += correction(reach, symbol);
        if (abs(w->want[at] - w->made[at]) > reach || w->head.corrections == MOST_CORRECTIONS)
            return ERR_UNSUPPORTED;
        w->head.corrections++;
        put_correction(&c, gap, symbol, w->writer);
        gap = 0;
    }
    return OK;
}

static status assemble(struct work *w, codec_blob *out)
{
    codec_blob symbols;
    size_t bits_at;
    status s = symbol_writer_finish(w->writer, &symbols, &bits_at);
    if (s) return s;
    w->head.holes = (uint32_t)w->holes.size;
    w->head.bits_at = (uint32_t)bits_at;
    w->head.check = predict_checksum(w->made);
    size_t size = HEAD + w->holes.size + symbols.size;
    unsigned char *data = malloc(size);
    if (data) {
        write_head(&w->head, data);
        if (w->holes.size) memcpy(data + HEAD, w->holes.data, w->holes.size);
        memcpy(data + HEAD + w->holes.size, symbols.data, symbols.size);
    }
    codec_blob_deinit(&symbols);
    *out = (codec_blob){data, data ? size : 0};
    return data ? OK : ERR_MEMORY;
}

// One way to a body: with coefficients of an rms error of that share of the bound.
static status encode_at(struct work *w, const float *samples, double share, codec_blob *out)
{
    // Half a step of a trellis is worth 0.6 of the step that has the same error.
    double step = 0.6 * sqrt(12) * share * (w->head.reach + 0.5);
    w->head.scale.step = (float)rint(8 * step) / 8;
    symbol_writer_clear(w->writer);
    status s = bands_encode(w->coefficients, &w->head.scale, w->writer, w->back);
    if (s) return s;
    wavelet_inverse(w->back, w->room);
    add_up(w->base, w->back, w->made);
    s = correct(w, samples);
    return s ? s : assemble(w, out);
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

// The smaller of *out and what another share gives. *smaller: it was that.
static status try_share(struct work *w, const float *samples, double share, double bound,
                        codec_blob *out, float *decoded, bool *smaller)
{
    codec_blob body;
    *smaller = false;
    status s = encode_at(w, samples, share, &body);
    if (s) return s == ERR_UNSUPPORTED ? OK : s;
    if (!out->size || body.size < out->size) {
        give_heights(w, samples, w->room);
        *smaller = is_within(samples, w->room, bound);
    }
    if (*smaller) {
        codec_blob_deinit(out);
        *out = body;
        memcpy(decoded, w->room, SAMPLES * sizeof *decoded);
    } else {
        codec_blob_deinit(&body);
    }
    return OK;
}

// *out stays empty when the tile cannot be coded so within the bound.
static status encode_residual(struct work *w, const float *samples, const float *predicted,
                              double max_error, bool holes, codec_blob *out, float *decoded)
{
    double quantum = ldexp(1, w->head.exponent), bound = max_error - quantum / 2;
    w->head.reach = (int)floor(bound / quantum);
    predict_count(predicted, w->head.exponent, w->base);
    for (int i = 0; i < SAMPLES; i++)
        w->coefficients[i] = isfinite(samples[i]) ? (float)(w->want[i] - w->base[i]) : 0;
    wavelet_forward(w->coefficients, w->room);
    bool smaller;
    status s = holes ? holes_encode(samples, &w->holes) : OK;
    if (!s) s = try_share(w, samples, shares[1], bound, out, decoded, &smaller);
    bool many = w->head.corrections > MANY_CORRECTIONS;
    if (!s) s = try_share(w, samples, shares[many ? 0 : 2], bound, out, decoded, &smaller);
    return s;
}

// The smallest of all kinds of bodies; decoded is what that one gives.
static status encode(struct work *w, const float *samples, const float *predicted, double max_error,
                     float *lossy, codec_blob *out, float *decoded)
{
    bool holes;
    codec_blob plain = {0}, body = {0};
    w->head.exponent = bounded_exponent(max_error);
    bool fits = grid_round(samples, w->head.exponent, w->want, &holes);
    status s = fits ? grid_encode(w->want, w->head.exponent, holes ? samples : NULL, &plain)
                    : codec_height_encode(samples, &plain);
    if (!s && fits) s = encode_residual(w, samples, predicted, max_error, holes, &body, lossy);
    bool rough = !s && body.size && body.size < plain.size;
    if (rough) memcpy(decoded, lossy, SAMPLES * sizeof *decoded);
    if (!s) *out = rough ? body : plain;
    if (s || !rough) codec_blob_deinit(&body);
    if (s || rough) codec_blob_deinit(&plain);
    return s;
}

status bounded_encode(const float *samples, const float *predicted, double max_error,
                      codec_blob *out, float *decoded)
{
    *out = (codec_blob){0};
    memcpy(decoded, samples, SAMPLES * sizeof *decoded);
    if (uniform_encode_height(samples, out)) return OK;
    struct work *w = calloc(1, sizeof *w);
    float *lossy = malloc(SAMPLES * sizeof *lossy);
    if (w) w->writer = symbol_writer_create();
    status s =
        w && lossy ? encode(w, samples, predicted, max_error, lossy, out, decoded) : ERR_MEMORY;
    if (w) symbol_writer_destroy(&w->writer);
    if (w) codec_blob_deinit(&w->holes);
    free(lossy);
    free(w);
    return s;
}

// The decoder

bool bounded_is_body(const void *data, size_t size)
{
    return bounded1_is_body(data, size) ||
           (size >= sizeof magic && memcmp(data, magic, sizeof magic) == 0);
}

// What is decoded on the way to heights.
struct decoder {
    float coefficients[SAMPLES], room[SAMPLES];
    int32_t base[SAMPLES], counts[SAMPLES];
};

status bounded_decode(const void *data, size_t size, const float *predicted, float *samples)
{
    if (bounded1_is_body(data, size)) return bounded1_decode(data, size, predicted, samples);
    struct head h;
    if (!read_head(data, size, &h)) return ERR_FORMAT;
    const unsigned char *holes = (const unsigned char *)data + HEAD, *symbols = holes + h.holes;
    struct decoder *d = malloc(sizeof *d);
    if (!d) return ERR_MEMORY;
    struct symbol_reader r = symbol_reader_begin(symbols, size - HEAD - h.holes, h.bits_at);
    bands_decode(&r, &h.scale, d->coefficients);
    wavelet_inverse(d->coefficients, d->room);
    predict_count(predicted, h.exponent, d->base);
    add_up(d->base, d->coefficients, d->counts);
    status s = get_corrections(&h, &r, d->counts) ? OK : ERR_FORMAT;
    if (!s && predict_checksum(d->counts) != h.check) s = ERR_FORMAT;
    if (!s) grid_heights(d->counts, h.exponent, samples);
    if (!s && h.holes) s = holes_decode(holes, h.holes, samples);
    free(d);
    return s;
}
