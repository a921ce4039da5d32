// Symbols of 0 to 15, each coded by how often it came before where it is expected: a table of
// frequencies that follows what is coded (as in AV1: Chen et al. 2018, 3.7), and a range coder
// whose state is one number (rANS: Duda 2013, arXiv:1311.2540, 4). Beside them plain bits. The
// library that has such a coder of its own, OpenJPEG, decodes at half the rate. Any thread.
#ifndef PERIGEE_PLANET_CODEC_SYMBOLS_H
#define PERIGEE_PLANET_CODEC_SYMBOLS_H

#include <stdbool.h>
#include <stdint.h>

#include "planet/codec.h"

enum { SYMBOL_COUNT = 16, SYMBOL_BITS = 15, SYMBOL_TOTAL = 1 << SYMBOL_BITS };

// Eight numbers that are worked on at once, as gcc and clang have them on every machine.
typedef int16_t symbol_eight __attribute__((vector_size(16)));

// below[s]: frequency, of SYMBOL_TOTAL, of the symbols below s.
// Invariant: it grows by at least one from symbol to symbol.
struct symbol_table {
    union {
        int16_t below[SYMBOL_COUNT];
        symbol_eight eights[SYMBOL_COUNT / 8];
    };
    int seen;
};

// Before the first symbol. weights: in proportion to the frequencies expected, > 0.
void symbol_table_init(struct symbol_table *table, const double weights[SYMBOL_COUNT]);

// Frequency of a symbol.
static inline int symbol_frequency(const struct symbol_table *t, int symbol)
{
    int above = symbol + 1 < SYMBOL_COUNT ? t->below[symbol + 1] : SYMBOL_TOTAL;
    return above - t->below[symbol];
}

// The table after a symbol has come. Every symbol keeps a frequency of one at least.
static inline void symbol_follow(struct symbol_table *t, int symbol)
{
    const symbol_eight first = {0, 1, 2, 3, 4, 5, 6, 7};
    int slow = 4 + (t->seen > 12) + (t->seen > 40) + (t->seen > 120) + (t->seen > 400);
    t->seen++;
    for (int i = 0; i < 2; i++) {
        symbol_eight s = first + (int16_t)(8 * i);
        symbol_eight to = s + ((s > (int16_t)symbol) & (int16_t)(SYMBOL_TOTAL - SYMBOL_COUNT));
        t->eights[i] += (((to - t->eights[i]) >> (int16_t)(slow - 1)) + 1) >> 1; // to the nearest
    }
}

// Symbols and bits on their way to a body.
struct symbol_writer;

struct symbol_writer *symbol_writer_create(void);
void symbol_writer_destroy(struct symbol_writer **writer);
void symbol_writer_clear(struct symbol_writer *writer);
void symbol_put(struct symbol_writer *writer, struct symbol_table *table, int symbol);
// The lowest `count` bits of `bits`, at most 32.
void symbol_put_bits(struct symbol_writer *writer, uint32_t bits, int count);
// What was put: the symbols, then the bits, whose place is *bits_at. ERR_MEMORY.
status symbol_writer_finish(struct symbol_writer *writer, codec_blob *out, size_t *bits_at);

// Reads what a writer has put, given the same tables. Beyond its end there are zeros, or the last
// word again: any bytes give some symbols.
struct symbol_reader {
    uint32_t state;
    const unsigned char *word, *last_word, *bytes, *bytes_end;
    uint64_t bits;
    int held;
};

// bits_at <= size.
struct symbol_reader symbol_reader_begin(const unsigned char *data, size_t size, size_t bits_at);

// Without branches, which symbols would not let the machine foresee.
static inline int symbol_get(struct symbol_reader *r, struct symbol_table *t)
{
    int16_t at = (int16_t)(r->state & (SYMBOL_TOTAL - 1));
    // -1 for every symbol that begins beyond.
    symbol_eight beyond = ((at - t->eights[0]) >> 15) + ((at - t->eights[1]) >> 15);
    int symbol = SYMBOL_COUNT - 1;
    for (int i = 0; i < 8; i++) symbol += beyond[i];
    uint32_t rest = (uint32_t)(at - t->below[symbol]);
    uint32_t state = (uint32_t)symbol_frequency(t, symbol) * (r->state >> SYMBOL_BITS) + rest;
    uint32_t word = (uint32_t)r->word[0] | (uint32_t)r->word[1] << 8;
    bool low = state < 1u << 16;
    r->state = low ? state << 16 | word : state;
    r->word += (low & (r->word < r->last_word)) ? 2 : 0;
    symbol_follow(t, symbol);
    return symbol;
}

static inline uint32_t symbol_get_bits(struct symbol_reader *r, int count)
{
    while (r->held < count) {
        for (int i = 0; i < 4; i++, r->held += 8)
            r->bits |= (uint64_t)(r->bytes < r->bytes_end ? *r->bytes++ : 0) << r->held;
    }
    uint32_t bits = (uint32_t)(r->bits & (((uint64_t)1 << count) - 1));
    r->bits >>= count;
    r->held -= count;
    return bits;
}

#endif
