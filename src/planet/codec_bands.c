// What the coder and the decoder share comes first: the numbers' symbols, and the tables that a
// number is coded by.
#include "planet/codec_bands.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "planet/wavelet.h"

enum {
    N = TILE_SIZE,
    SAMPLES = N * N,
    STATES = 4,
    CONTEXTS = 23,
    KINDS = 3,
    // Amounts of neighbours count up to this.
    MOST_SEEN = 127,
    // Over the greatest sum of weighted amounts.
    SUMS = 2048,
    EXACT = 10, // symbols up to here are the number itself
    WIDEST_BITS = 26
};

// A symbol stands for numbers from lowest[symbol] on, of which plain bits say which.
static const int lowest[SYMBOL_COUNT + 1] = {0, 1,  2,  3,  4,  5,  6,   7,      8,
                                             9, 10, 12, 16, 32, 64, 128, 1 << 26};
static const int plain_bits[SYMBOL_COUNT] = {0, 0, 0, 0, 0, 0, 0, 0,
                                             0, 0, 1, 2, 4, 5, 6, WIDEST_BITS};

// State after a number, by its parity. States 0 and 1 stand for even steps, 2 and 3 for odd ones.
static const unsigned char next_state[STATES][2] = {{0, 2}, {2, 0}, {1, 3}, {3, 1}};

// Least weighted sum of the amounts around for each context; five to four for twice the amount.
static const int context_sums[CONTEXTS] = {0,  1,  2,  3,   5,   6,   9,   12,  17,  23,  30, 41,
                                           54, 72, 95, 126, 167, 221, 292, 386, 510, 673, 889};

struct coder {
    struct wavelet_band bands[WAVELET_BANDS];
    struct symbol_table tables[KINDS][2][CONTEXTS];
    unsigned char context_of[SUMS];
    // Amounts of the numbers so far, up to MOST_SEEN, at the coefficients' places.
    unsigned char seen[SAMPLES];
};

static int symbol_of(int number)
{
    int symbol = number < EXACT ? number : EXACT;
    while (number >= lowest[symbol + 1]) symbol++;
    return symbol;
}

// Numbers whose mean amount is about 1/16 of the sum: geometric, odd steps half a number farther.
static void init_table(struct symbol_table *t, int context, bool odd)
{
    double mean = context_sums[context] / 16.0 + 0.02 + (odd && context > 2 ? 0.5 : 0);
    double ratio = mean / (1 + mean), power = 1, weights[SYMBOL_COUNT];
    for (int i = 0; i < SYMBOL_COUNT; i++) {
        weights[i] = power + 1e-5;
        for (int k = lowest[i]; k < lowest[i + 1] && i + 1 < SYMBOL_COUNT; k++) power *= ratio;
        if (i + 1 < SYMBOL_COUNT) weights[i] -= power;
    }
    symbol_table_init(t, weights);
}

static struct coder *coder_create(void)
{
    struct coder *c = NEW(struct coder);
    wavelet_bands(c->bands);
    for (int context = 0; context < CONTEXTS; context++)
        for (int odd = 0; odd < 2; odd++) {
            init_table(&c->tables[0][odd][context], context, odd);
            for (int kind = 1; kind < KINDS; kind++)
                c->tables[kind][odd][context] = c->tables[0][odd][context];
        }
    for (int sum = 0, context = 0; sum < SUMS; sum++) {
        while (context + 1 < CONTEXTS && sum >= context_sums[context + 1]) context++;
        c->context_of[sum] = (unsigned char)context;
    }
    return c;
}

// Tables of the coarser levels, of the finest and of its diagonal band.
static int kind_of(const struct wavelet_band *b)
{
    return b->level > 1 ? 0 : b->tall && b->wide ? 2 : 1;
}

// The weighted amounts around the coefficients of a row, but for those to the west: rows before it
// in the band, the coarser band at the same place, bands of the same level that come before.
static void sum_above(const struct coder *c, const struct wavelet_band *b, int y, uint16_t *sums)
{
    static const unsigned char none[N];
    int n = b->n;
    const unsigned char *row = c->seen + (b->row + y) * N + b->col;
    const unsigned char *north = y > 0 ? row - N : none, *second = y > 1 ? row - 2 * N : none;
    for (int x = 0; x < n; x++) sums[x] = (uint16_t)(4 * north[x] + second[x]);
    for (int x = 1; x < n; x++) sums[x] = (uint16_t)(sums[x] + north[x - 1]);
    for (int x = 0; x < n - 1; x++) sums[x] = (uint16_t)(sums[x] + north[x + 1]);
    if (b->level < WAVELET_LEVELS) {
        const unsigned char *coarser = c->seen + (b->row + y) / 2 * N + b->col / 2;
        for (int x = 0; x < n; x++) sums[x] = (uint16_t)(sums[x] + coarser[x / 2]);
    }
    if (!b->tall) return;
    const unsigned char *wide = c->seen + y * N + n, *tall = c->seen + (n + y) * N;
    for (int x = 0; x < n; x++) sums[x] = (uint16_t)(sums[x] + wide[x]);
    for (int x = 0; x < n && b->wide; x++) sums[x] = (uint16_t)(sums[x] + tall[x]);
}

static inline int context_of(const struct coder *c, int sum, int west, int farther)
{
    return c->context_of[sum + 4 * west + farther];
}

static inline int amount_seen(int number)
{
    return number < MOST_SEEN ? number : MOST_SEEN;
}

// The coder

// A step's square for a bit: what a number may be off for each bit that it saves. At the slope of
// rate and error of an even field this would be 0.37 (4 steps^2 / 12 * 0.8 * 2 ln 2).
#define BIT_PRICE 0.35f

// The best way to one state: what it costs, and the amounts of its last two numbers.
struct way {
    float cost;
    int west, farther;
};

// Amounts of so few steps are 0 in any case.
#define SMALL 0.3f

enum { LOGS = 1 << 11, LOG_SHIFT = 4 };

struct chooser {
    float bits[LOGS];                       // of a symbol, by its frequency >> LOG_SHIFT
    float price[2][CONTEXTS][SYMBOL_COUNT]; // of symbols, with sign and plain bits
    int numbers[N / 2][STATES];
    unsigned char from[N / 2][STATES];
};

static struct chooser *chooser_create(void)
{
    struct chooser *ch = NEW(struct chooser);
    for (int i = 0; i < LOGS; i++)
        ch->bits[i] = log2f((float)SYMBOL_TOTAL / (((float)i + 0.5f) * (1 << LOG_SHIFT)));
    return ch;
}

static void find_prices(struct symbol_table tables[2][CONTEXTS], struct chooser *ch)
{
    for (int odd = 0; odd < 2; odd++)
        for (int context = 0; context < CONTEXTS; context++)
            for (int s = 0; s < SYMBOL_COUNT; s++) {
                int f = symbol_frequency(&tables[odd][context], s);
                float bits = ch->bits[f >> LOG_SHIFT] + (float)((s > 0) + plain_bits[s]);
                ch->price[odd][context][s] = BIT_PRICE * bits;
            }
}

// The next ways by all numbers worth trying for an amount of `steps`.
static void go_on(const struct coder *c, struct chooser *ch, int x, int sum, float steps,
                  const struct way ways[STATES], struct way next[STATES])
{
    for (int s = 0; s < STATES; s++) next[s] = (struct way){.cost = INFINITY};
    for (int s = 0; s < STATES; s++) {
        if (!(ways[s].cost < INFINITY)) continue;
        int odd = s >> 1, below = (int)((steps + (float)odd) * 0.5f);
        const float *price = ch->price[odd][context_of(c, sum, ways[s].west, ways[s].farther)];
        int tried[3] = {below, below + 1, 0}, count = below > 0 && below < 3 ? 3 : 2;
        if (steps < SMALL) count = 1;
        for (int i = 0; i < count; i++) {
            int number = tried[i], to = next_state[s][number & 1];
            float off = steps - (number ? (float)(2 * number - odd) : 0);
            float cost = ways[s].cost + off * off + price[symbol_of(number)];
            if (!(cost < next[to].cost)) continue;
            next[to] = (struct way){cost, amount_seen(number), ways[s].west};
            ch->numbers[x][to] = number;
            ch->from[x][to] = (unsigned char)s;
        }
    }
}

// The numbers of a row of n amounts in steps, from the state before it on.
static void choose_row(const struct coder *c, struct chooser *ch, const uint16_t *sums,
                       const float *steps, int n, int state, int *numbers)
{
    struct way ways[STATES], next[STATES];
    for (int s = 0; s < STATES; s++) ways[s] = (struct way){.cost = s == state ? 0 : INFINITY};
    for (int x = 0; x < n; x++) {
        go_on(c, ch, x, sums[x], steps[x], ways, next);
        memcpy(ways, next, sizeof ways);
    }
    int best = 0;
    for (int s = 1; s < STATES; s++)
        if (ways[s].cost < ways[best].cost) best = s;
    for (int x = n - 1; x >= 0; x--) {
        numbers[x] = ch->numbers[x][best];
        best = ch->from[x][best];
    }
}

// Sum and number of what amounts are off, of numbers 1 and of greater ones.
struct offsets {
    double sum[2], count[2];
};

static void put_row(struct coder *c, const struct wavelet_band *b, int y, const uint16_t *sums,
                    const float *coefficients, const int *numbers, int *state,
                    struct symbol_writer *w)
{
    struct symbol_table(*tables)[CONTEXTS] = c->tables[kind_of(b)];
    unsigned char *seen = c->seen + (b->row + y) * N + b->col;
    for (int x = 0, west = 0, farther = 0; x < b->n; x++) {
        int number = numbers[x], symbol = symbol_of(number);
        symbol_put(w, &tables[*state >> 1][context_of(c, sums[x], west, farther)], symbol);
        if (number) symbol_put_bits(w, coefficients[x] < 0, 1);
        symbol_put_bits(w, (uint32_t)(number - lowest[symbol]), plain_bits[symbol]);
        farther = west;
        west = amount_seen(number);
        seen[x] = (unsigned char)west;
        *state = next_state[*state][number & 1];
    }
}

// What numbers stand for, in steps; what the amounts are off from that goes into *o.
static void add_offsets(struct offsets *o, const float *steps, const int *numbers, int n, int state,
                        float *amounts)
{
    for (int x = 0; x < n; x++) {
        int number = numbers[x], great = number > 1;
        amounts[x] = number ? (float)(2 * number - (state >> 1)) : 0;
        if (number) {
            o->sum[great] += (double)(steps[x] - amounts[x]);
            o->count[great]++;
        }
        state = next_state[state][number & 1];
    }
}

// False when an amount is beyond the code.
static bool put_band(struct coder *c, struct chooser *ch, const struct wavelet_band *b,
                     const float *coefficients, float step, int *state, struct offsets *o,
                     struct symbol_writer *w, float *amounts)
{
    const float scale = b->norm / step, limit = 1 << WIDEST_BITS;
    for (int y = 0; y < b->n; y++) {
        uint16_t sums[N / 2];
        float steps[N / 2];
        int numbers[N / 2];
        const float *row = coefficients + (b->row + y) * N + b->col;
        for (int x = 0; x < b->n; x++) {
            steps[x] = fabsf(row[x]) * scale;
            if (!(steps[x] < limit)) return false;
        }
        sum_above(c, b, y, sums);
        find_prices(c->tables[kind_of(b)], ch);
        choose_row(c, ch, sums, steps, b->n, *state, numbers);
        add_offsets(o, steps, numbers, b->n, *state, amounts + (b->row + y) * N + b->col);
        put_row(c, b, y, sums, row, numbers, state, w);
    }
    return true;
}

// Levels from the finest on without an amount that could become a number.
static int empty_levels(const struct wavelet_band *bands, const float *coefficients, float step)
{
    int level = 1;
    for (int k = WAVELET_BANDS - 1; k > 0; k--) {
        const struct wavelet_band *b = &bands[k];
        float most = 0, scale = b->norm / step;
        for (int y = 0; y < b->n; y++)
            for (int x = 0; x < b->n; x++)
                most = fmaxf(most, fabsf(coefficients[(b->row + y) * N + b->col + x]));
        if (most * scale >= 1) return level - 1;
        level = b->level + (k % 3 == 1);
    }
    return level - 1;
}

static signed char mean_shift(double sum, double count)
{
    double mean = count > 0 ? rint(128 * sum / count) : 0;
    return (signed char)(mean < -127 ? -127 : mean > 127 ? 127 : mean);
}

// From amounts in steps to coefficients, as the decoder does it.
static void scale_back(const struct wavelet_band *b, const struct bands_scale *scale,
                       const float shift[2], const float *coefficients, float *back)
{
    const float step = scale->step / b->norm;
    for (int y = 0; y < b->n; y++)
        for (int x = 0; x < b->n; x++) {
            int at = (b->row + y) * N + b->col + x;
            if (back[at] == 0) continue;
            float amount = (back[at] + shift[back[at] > 2]) * step; // of 1 there are 1 or 2 steps
            back[at] = coefficients[at] < 0 ? -amount : amount;
        }
}

static void read_shift(const struct bands_scale *scale, float shift[2])
{
    for (int i = 0; i < 2; i++) shift[i] = (float)scale->shift[i] / 128;
}

status bands_encode(const float *coefficients, struct bands_scale *scale, struct symbol_writer *w,
                    float *back)
{
    struct coder *c = coder_create();
    struct chooser *ch = chooser_create();
    struct offsets o = {0};
    float shift[2];
    memset(back, 0, SAMPLES * sizeof *back);
    scale->empty = (unsigned char)empty_levels(c->bands, coefficients, scale->step);
    bool good = true;
    for (int k = 0, state = 0; good && k < WAVELET_BANDS; k++)
        if (k == 0 || c->bands[k].level > scale->empty)
            good = put_band(c, ch, &c->bands[k], coefficients, scale->step, &state, &o, w, back);
    for (int i = 0; i < 2; i++) scale->shift[i] = mean_shift(o.sum[i], o.count[i]);
    read_shift(scale, shift);
    for (int k = 0; k < WAVELET_BANDS; k++)
        scale_back(&c->bands[k], scale, shift, coefficients, back);
    free(ch);
    free(c);
    return good ? OK : ERR_UNSUPPORTED;
}

// The decoder

// What numbers up to EXACT stand for, by sign and whether steps are odd.
struct amounts {
    float of[2][2][EXACT];
    float step, shift[2];
};

static void find_amounts(struct amounts *a, const struct bands_scale *scale,
                         const struct wavelet_band *b)
{
    a->step = scale->step / b->norm;
    read_shift(scale, a->shift);
    for (int odd = 0; odd < 2; odd++)
        for (int number = 0; number < EXACT; number++) {
            float amount = ((float)(2 * number - odd) + a->shift[number > 1]) * a->step;
            a->of[0][odd][number] = number ? amount : 0;
            a->of[1][odd][number] = number ? -amount : 0;
        }
}

static int get_row(struct coder *c, const struct wavelet_band *b, int y, const struct amounts *a,
                   int state, struct symbol_reader *reader, float *row)
{
    struct symbol_table(*tables)[CONTEXTS] = c->tables[kind_of(b)];
    unsigned char *seen = c->seen + (b->row + y) * N + b->col;
    struct symbol_reader r = *reader;
    uint16_t sums[N / 2];
    sum_above(c, b, y, sums);
    for (int x = 0, west = 0, farther = 0; x < b->n; x++) {
        int odd = state >> 1;
        int number = symbol_get(&r, &tables[odd][context_of(c, sums[x], west, farther)]);
        int minus = (int)symbol_get_bits(&r, number > 0);
        farther = west;
        west = number;
        if (number < EXACT) {
            row[x] = a->of[minus][odd][number];
        } else {
            number = lowest[number] + (int)symbol_get_bits(&r, plain_bits[number]);
            float amount = ((float)(2 * number - odd) + a->shift[1]) * a->step;
            row[x] = minus ? -amount : amount;
            west = amount_seen(number);
        }
        seen[x] = (unsigned char)west;
        state = next_state[state][number & 1];
    }
    *reader = r;
    return state;
}

void bands_decode(struct symbol_reader *reader, const struct bands_scale *scale,
                  float *coefficients)
{
    struct coder *c = coder_create();
    struct amounts amounts;
    memset(coefficients, 0, SAMPLES * sizeof *coefficients);
    for (int k = 0, state = 0; k < WAVELET_BANDS; k++) {
        const struct wavelet_band *b = &c->bands[k];
        if (k > 0 && b->level <= scale->empty) continue;
        find_amounts(&amounts, scale, b);
        for (int y = 0; y < b->n; y++)
            state =
                get_row(c, b, y, &amounts, state, reader, coefficients + (b->row + y) * N + b->col);
    }
    free(c);
}
