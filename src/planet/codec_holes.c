#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <zstd.h>

#include "planet/codec_grid.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE, MASK = SAMPLES / 8, LEVEL = 3 };

status holes_encode(const float *samples, codec_blob *out)
{
    unsigned char mask[MASK] = {0};
    *out = (codec_blob){0};
    for (int i = 0; i < SAMPLES; i++)
        if (!isfinite(samples[i])) mask[i / 8] |= (unsigned char)(1u << (i % 8));
    size_t room = ZSTD_compressBound(MASK);
    unsigned char *data = malloc(room);
    if (!data) return ERR_MEMORY;
    size_t size = ZSTD_compress(data, room, mask, MASK, LEVEL);
    if (ZSTD_isError(size)) {
        free(data);
        return ERR_MEMORY; // into room enough for anything, nothing else can fail
    }
    *out = (codec_blob){data, size};
    return OK;
}

status holes_decode_mask(const void *data, size_t size, unsigned char *mask)
{
    size_t got = ZSTD_decompress(mask, MASK, data, size);
    return ZSTD_isError(got) || got != MASK ? ERR_FORMAT : OK;
}

status holes_decode(const void *data, size_t size, float *samples)
{
    unsigned char mask[MASK];
    if (holes_decode_mask(data, size, mask)) return ERR_FORMAT;
    for (int i = 0; i < SAMPLES; i++)
        if (mask[i / 8] >> (i % 8) & 1) samples[i] = NAN;
    return OK;
}
