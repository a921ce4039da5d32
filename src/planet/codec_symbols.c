// The range coder runs backwards, so that its reader can run forwards: symbols are kept until all
// are known.
#include "planet/codec_symbols.h"

#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

// Of the range coder's state, which stays in [LOWEST, LOWEST << 16).
#define LOWEST (1u << 16)

struct interval {
    uint16_t below, frequency;
};

struct symbol_writer {
    struct interval *symbols;
    size_t count, room;
    unsigned char *bytes;
    size_t size, bytes_room;
    uint64_t bits;
    int held;
};

void symbol_table_init(struct symbol_table *t, const double weights[SYMBOL_COUNT])
{
    double sum = 0, below = 0;
    for (int i = 0; i < SYMBOL_COUNT; i++) sum += weights[i];
    for (int i = 0; i < SYMBOL_COUNT; i++) {
        t->below[i] = (int16_t)(i + (int)(below / sum * (SYMBOL_TOTAL - SYMBOL_COUNT)));
        below += weights[i];
    }
    t->seen = 0;
}

struct symbol_writer *symbol_writer_create(void)
{
    return NEW(struct symbol_writer);
}

void symbol_writer_destroy(struct symbol_writer **writer)
{
    if (!*writer) return;
    free((*writer)->symbols);
    free((*writer)->bytes);
    free(*writer);
    *writer = NULL;
}

void symbol_writer_clear(struct symbol_writer *w)
{
    w->count = w->size = 0;
    w->bits = 0;
    w->held = 0;
}

// Twice the room, what it holds kept.
static void *grow(void *data, size_t count, size_t *room, size_t each)
{
    *room = 2 * *room + 4096;
    char *wider = NEW_ARRAY(char, *room *each);
    if (count) memcpy(wider, data, count * each);
    free(data);
    return wider;
}

void symbol_put(struct symbol_writer *w, struct symbol_table *t, int symbol)
{
    if (w->count == w->room) w->symbols = grow(w->symbols, w->count, &w->room, sizeof *w->symbols);
    w->symbols[w->count++] =
        (struct interval){(uint16_t)t->below[symbol], (uint16_t)symbol_frequency(t, symbol)};
    symbol_follow(t, symbol);
}

void symbol_put_bits(struct symbol_writer *w, uint32_t bits, int count)
{
    w->bits |= ((uint64_t)bits & (((uint64_t)1 << count) - 1)) << w->held;
    w->held += count;
    for (; w->held >= 8; w->held -= 8, w->bits >>= 8) {
        if (w->size == w->bytes_room) w->bytes = grow(w->bytes, w->size, &w->bytes_room, 1);
        w->bytes[w->size++] = (unsigned char)w->bits;
    }
}

// The range coder's words, last first; their number.
static size_t code_symbols(const struct symbol_writer *w, uint16_t *words, uint32_t *state)
{
    size_t n = 0;
    uint32_t x = LOWEST;
    for (size_t i = w->count; i-- > 0;) {
        uint32_t f = w->symbols[i].frequency;
        if (x >= (uint64_t)f << (32 - SYMBOL_BITS)) {
            words[n++] = (uint16_t)x;
            x >>= 16;
        }
        x = (x / f << SYMBOL_BITS) + x % f + w->symbols[i].below;
    }
    *state = x;
    return n;
}

status symbol_writer_finish(struct symbol_writer *w, codec_blob *out, size_t *bits_at)
{
    uint32_t state;
    uint16_t *words = NEW_ARRAY(uint16_t, w->count + 1);
    size_t n = code_symbols(w, words, &state);
    *bits_at = 4 + 2 * n;
    size_t size = *bits_at + w->size + (w->held > 0);
    unsigned char *data = malloc(size), *at = data;
    *out = (codec_blob){data, data ? size : 0};
    for (int i = 0; data && i < 4; i++) *at++ = (unsigned char)(state >> (8 * i));
    for (; data && n > 0; n--) {
        *at++ = (unsigned char)words[n - 1];
        *at++ = (unsigned char)(words[n - 1] >> 8);
    }
    if (data && w->size) memcpy(at, w->bytes, w->size);
    if (data && w->held) at[w->size] = (unsigned char)w->bits;
    free(words);
    return data ? OK : ERR_MEMORY;
}

struct symbol_reader symbol_reader_begin(const unsigned char *data, size_t size, size_t bits_at)
{
    static const unsigned char none[2];
    bool words = bits_at >= 6;
    struct symbol_reader r = {.word = words ? data + 4 : none,
                              .last_word = words ? data + 4 + (bits_at - 6) / 2 * 2 : none,
                              .bytes = data + bits_at,
                              .bytes_end = data + size};
    for (int i = 0; i < 4 && bits_at >= 4; i++) r.state |= (uint32_t)data[i] << (8 * i);
    return r;
}
