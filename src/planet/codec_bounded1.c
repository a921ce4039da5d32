// Bodies of the first kind ("PGB1"), which this program reads but does not make. A head of 32
// bytes, the holes, the picture, the corrections. The head, little-endian: "PGB1", the quantum's
// exponent, whether the corrections are compressed, two bytes of zero, then four bytes each: the
// step of a correction in quanta, the size of the holes, of the picture (0: none) and of the
// corrections, the XXH32 of the counts decoded, four bytes of zero.
#include "planet/codec_bounded1.h"

#include <stdlib.h>
#include <string.h>
#include <zstd.h>

#include "planet/codec_grid.h"
#include "planet/codec_jpeg2000.h"
#include "planet/codec_predict.h"

enum {
    SAMPLES = TILE_SIZE * TILE_SIZE,
    HEAD = 32,
    // A gap of 65535 in steps of 255 and a correction of five bytes, or one byte of gap each.
    MAX_CORRECTIONS = SAMPLES * 6 + 512
};

static const char magic[4] = {'P', 'G', 'B', '1'};

struct head {
    int exponent;
    bool packed;
    uint32_t step, holes, picture, corrections, check;
};

static uint32_t read_word(const unsigned char *in)
{
    return (uint32_t)in[0] | (uint32_t)in[1] << 8 | (uint32_t)in[2] << 16 | (uint32_t)in[3] << 24;
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

// The corrections: for each a gap (bytes of 255 and a last one below), then the count of steps,
// folded to 0, -1, 1, ... in bytes of seven bits, the lowest first, each but the last with the
// eighth set. Adds what they say. False when they are none, or run out of the tile.
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

bool bounded1_is_body(const void *data, size_t size)
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

status bounded1_decode(const void *data, size_t size, const float *predicted, float *samples)
{
    struct head h;
    if (!read_head(data, size, &h)) return ERR_FORMAT;
    const unsigned char *holes = (const unsigned char *)data + HEAD, *picture = holes + h.holes;
    int32_t *counts = malloc(2 * SAMPLES * sizeof *counts);
    if (!counts) return ERR_MEMORY;
    int32_t *made = counts + SAMPLES;
    predict_count(predicted, h.exponent, counts);
    status s = OK;
    if (h.picture) s = jpeg2000_decode(picture, h.picture, made);
    for (int i = 0; !s && h.picture && i < SAMPLES; i++)
        counts[i] = (int32_t)((uint32_t)counts[i] + (uint32_t)made[i]);
    if (!s) s = unpack_corrections(&h, picture + h.picture, counts);
    if (!s && predict_checksum(counts) != h.check) s = ERR_FORMAT;
    if (!s) grid_heights(counts, h.exponent, samples);
    if (!s && h.holes) s = holes_decode(holes, h.holes, samples);
    free(counts);
    return s;
}
