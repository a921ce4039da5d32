// The body: "PGL1", the quantum's exponent, the bits of a coded difference, two bytes of zero, the
// size of the holes as four bytes (little-endian), the holes, the differences.
#include "planet/codec_grid.h"

#include <float.h>
#include <libaec.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/vector.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE, HEAD = 12, BLOCK = 16, BLOCKS_A_REFERENCE = 128 };

static const char magic[4] = {'P', 'G', 'L', '1'};

// The whole number nearest to |v| < 2^23, ties to the even one.
VECTOR_INLINE int32_t nearest_small(float v)
{
    float shift = copysignf(0x1p23f, v); // floats of this size and twice it are the whole numbers
    return (int32_t)(v + shift - shift);
}

VECTOR_CLONES bool grid_round(const float *samples, int exponent, int32_t *counts, bool *holes)
{
    const float scale = ldexpf(1, -exponent), limit = (float)GRID_COUNT_LIMIT;
    int missing = 0, high = 0;
    for (int i = 0; i < SAMPLES; i++) {
        float v = samples[i] * scale, size = fabsf(v);
        missing |= !(fabsf(samples[i]) <= FLT_MAX);
        high |= (size >= limit) & (fabsf(samples[i]) <= FLT_MAX);
        counts[i] = nearest_small(size < limit ? v : 0);
    }
    *holes = missing;
    for (int i = 1; missing && i < SAMPLES; i++)
        if (!isfinite(samples[i])) counts[i] = counts[i - 1];
    return !high;
}

VECTOR_CLONES void grid_heights(const int32_t *counts, int exponent, float *samples)
{
    const float quantum = ldexpf(1, exponent);
    for (int i = 0; i < SAMPLES; i++) samples[i] = (float)counts[i] * quantum;
}

// Differences stand as 0, -1, 1, -2, 2, ...
static uint32_t fold(uint32_t v)
{
    return v << 1 ^ (0u - (v >> 31));
}

static uint32_t unfold(uint32_t v)
{
    return v >> 1 ^ (0u - (v & 1));
}

static int32_t predict(int32_t west, int32_t north, int32_t corner)
{
    int32_t low = west < north ? west : north, high = west < north ? north : west;
    int32_t plane = (int32_t)((uint32_t)west + (uint32_t)north - (uint32_t)corner);
    return plane < low ? low : plane > high ? high : plane;
}

VECTOR_CLONES static void take_differences(const int32_t *counts, uint32_t *out)
{
    for (int y = 0; y < TILE_SIZE; y++) {
        const int32_t *row = counts + (size_t)y * TILE_SIZE, *above = row - TILE_SIZE;
        uint32_t *to = out + (size_t)y * TILE_SIZE;
        to[0] = fold((uint32_t)row[0] - (y ? (uint32_t)above[0] : 0));
        for (int x = 1; x < TILE_SIZE; x++) {
            int32_t p = y ? predict(row[x - 1], above[x], above[x - 1]) : row[x - 1];
            to[x] = fold((uint32_t)row[x] - (uint32_t)p);
        }
    }
}

// Wraps where a body from elsewhere makes it; the caller looks at the limits.
static void add_differences(const uint32_t *in, int32_t *counts)
{
    for (int y = 0; y < TILE_SIZE; y++) {
        int32_t *row = counts + (size_t)y * TILE_SIZE;
        const int32_t *above = row - TILE_SIZE;
        const uint32_t *from = in + (size_t)y * TILE_SIZE;
        int32_t west = (int32_t)((y ? (uint32_t)above[0] : 0) + unfold(from[0]));
        row[0] = west;
        for (int x = 1; x < TILE_SIZE; x++) {
            int32_t p = y ? predict(west, above[x], above[x - 1]) : west;
            west = (int32_t)((uint32_t)p + unfold(from[x]));
            row[x] = west;
        }
    }
}

VECTOR_CLONES static int bits_of(const uint32_t *values)
{
    uint32_t all = 0;
    int bits = 1;
    for (int i = 0; i < SAMPLES; i++) all |= values[i];
    while (bits < 32 && all >> bits) bits++;
    return bits;
}

// As the coder takes samples of that many bits: 1, 2 or 4 bytes, the host's order.
static int bytes_of(int bits)
{
    return bits <= 8 ? 1 : bits <= 16 ? 2 : 4;
}

VECTOR_CLONES static void narrow(const uint32_t *values, int bytes, void *out)
{
    for (int i = 0; i < SAMPLES; i++) {
        if (bytes == 1) ((uint8_t *)out)[i] = (uint8_t)values[i];
        else if (bytes == 2) ((uint16_t *)out)[i] = (uint16_t)values[i];
        else ((uint32_t *)out)[i] = values[i];
    }
}

VECTOR_CLONES static void widen(const void *in, int bytes, uint32_t *values)
{
    for (int i = 0; i < SAMPLES; i++)
        values[i] = bytes == 1   ? ((const uint8_t *)in)[i]
                    : bytes == 2 ? ((const uint16_t *)in)[i]
                                 : ((const uint32_t *)in)[i];
}

static struct aec_stream coder(int bits)
{
    return (struct aec_stream){.bits_per_sample = (unsigned)bits,
                               .block_size = BLOCK,
                               .rsi = BLOCKS_A_REFERENCE,
                               .flags = __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__ ? AEC_DATA_MSB : 0};
}

static void write_head(unsigned char *head, int exponent, int bits, size_t holes)
{
    memset(head, 0, HEAD);
    memcpy(head, magic, sizeof magic);
    head[4] = (unsigned char)(signed char)exponent;
    head[5] = (unsigned char)bits;
    for (int i = 0; i < 4; i++) head[8 + i] = (unsigned char)(holes >> (8 * i));
}

static status encode_into(const int32_t *counts, int exponent, const codec_blob *holes,
                          uint32_t *room, codec_blob *out)
{
    take_differences(counts, room);
    int bits = bits_of(room), bytes = bytes_of(bits);
    void *raw = room + SAMPLES;
    narrow(room, bytes, raw);
    // What does not compress takes its own bits and one in BLOCK more.
    size_t at = HEAD + holes->size, most = at + SAMPLES * 4 + SAMPLES / 4;
    unsigned char *data = malloc(most);
    if (!data) return ERR_MEMORY;
    write_head(data, exponent, bits, holes->size);
    if (holes->size) memcpy(data + HEAD, holes->data, holes->size);
    struct aec_stream s = coder(bits);
    s.next_in = raw;
    s.avail_in = (size_t)SAMPLES * (size_t)bytes;
    s.next_out = data + at;
    s.avail_out = most - at;
    if (aec_buffer_encode(&s) != AEC_OK) {
        free(data);
        return ERR_MEMORY; // of a fixed size into room enough, nothing else can fail
    }
    unsigned char *fit = realloc(data, at + s.total_out);
    *out = (codec_blob){fit ? fit : data, at + s.total_out};
    return OK;
}

status grid_encode(const int32_t *counts, int exponent, const float *holes, codec_blob *out)
{
    *out = (codec_blob){0};
    codec_blob mask = {0};
    uint32_t *room = malloc(2 * SAMPLES * sizeof *room);
    status s = room ? OK : ERR_MEMORY;
    if (!s && holes) s = holes_encode(holes, &mask);
    if (!s) s = encode_into(counts, exponent, &mask, room, out);
    codec_blob_deinit(&mask);
    free(room);
    return s;
}

bool grid_is_body(const void *data, size_t size)
{
    return size >= sizeof magic && memcmp(data, magic, sizeof magic) == 0;
}

// The differences at the end of a body, in `room`. False when there are not just that many.
static bool read_differences(const unsigned char *data, size_t size, int bits, void *raw,
                             uint32_t *room)
{
    int bytes = bytes_of(bits);
    struct aec_stream s = coder(bits);
    s.next_in = data;
    s.avail_in = size;
    s.next_out = raw;
    s.avail_out = (size_t)SAMPLES * (size_t)bytes;
    if (aec_buffer_decode(&s) != AEC_OK || s.avail_out) return false;
    widen(raw, bytes, room);
    return true;
}

static bool within_limit(const int32_t *counts)
{
    int bad = 0;
    for (int i = 0; i < SAMPLES; i++)
        bad += counts[i] <= -GRID_COUNT_LIMIT || counts[i] >= GRID_COUNT_LIMIT;
    return bad == 0;
}

// holes: bytes of them, after the head.
static bool read_head(const unsigned char *body, size_t size, int *exponent, int *bits,
                      size_t *holes)
{
    if (size < HEAD) return false;
    *exponent = (signed char)body[4];
    *bits = body[5];
    *holes = 0;
    for (int i = 3; i >= 0; i--) *holes = *holes << 8 | body[8 + i];
    return *exponent >= GRID_EXPONENT_MIN && *exponent <= GRID_EXPONENT_MAX && *bits >= 1 &&
           *bits <= 32 && !body[6] && !body[7] && *holes <= size - HEAD;
}

status grid_holes(const void *data, size_t size, unsigned char *mask)
{
    int exponent, bits;
    size_t holes;
    if (!read_head(data, size, &exponent, &bits, &holes)) return ERR_FORMAT;
    if (holes) return holes_decode_mask((const unsigned char *)data + HEAD, holes, mask);
    memset(mask, 0, SAMPLES / 8);
    return OK;
}

status grid_decode(const void *data, size_t size, float *samples)
{
    const unsigned char *body = data;
    int exponent, bits;
    size_t holes;
    if (!read_head(body, size, &exponent, &bits, &holes)) return ERR_FORMAT;
    uint32_t *room = malloc(3 * SAMPLES * sizeof *room);
    if (!room) return ERR_MEMORY;
    int32_t *counts = (int32_t *)(room + SAMPLES);
    status s = ERR_FORMAT;
    if (read_differences(body + HEAD + holes, size - HEAD - holes, bits, room + 2 * SAMPLES,
                         room)) {
        add_differences(room, counts);
        if (within_limit(counts)) s = OK;
    }
    if (!s) grid_heights(counts, exponent, samples);
    if (!s && holes) s = holes_decode(body + HEAD, holes, samples);
    free(room);
    return s;
}
