// What bounded bodies are made of: the wavelet against its published filters, symbols against their
// entropy, coefficients against the least that any code takes.
#include "check.h"

#include "planet/codec_bands.h"
#include "planet/wavelet.h"

enum { SAMPLES = TILE_SIZE * TILE_SIZE };

static float samples[SAMPLES], kept[SAMPLES], back[SAMPLES], room[SAMPLES];

static double normal(struct check_random *r)
{
    double u = check_random_range(r, 1e-12, 1), v = check_random_range(r, 0, 2 * M_PI);
    return sqrt(-2 * log(u)) * cos(v);
}

// Fails when a step of the way back is left out, its sign or its order is changed.
static void the_wavelet_goes_back(void **state)
{
    (void)state;
    struct check_random random = {7};
    for (int i = 0; i < SAMPLES; i++)
        kept[i] = samples[i] = (float)check_random_range(&random, -1000, 1000);
    wavelet_forward(samples, room);
    wavelet_inverse(samples, room);
    for (int i = 0; i < SAMPLES; i++) check_near(samples[i], kept[i], 0.01);
}

// Analysis filters of the 9/7 wavelet, Antonini, Barlaud, Mathieu & Daubechies 1992, table II,
// from the centre on, for sums of sqrt(2) and 0.
static const double low_filter[] = {0.852699, 0.377403, -0.110624, -0.023849, 0.037828};
static const double high_filter[] = {0.788485, -0.418092, -0.040690, 0.064539};

// A spot in the middle, seen by the finest bands: their norms times what they hold are the products
// of the published filters. Fails when a lifting constant or a norm is off, or bands are mistaken.
static void the_finest_bands_are_the_published_filters(void **state)
{
    (void)state;
    struct wavelet_band bands[WAVELET_BANDS];
    wavelet_bands(bands);
    memset(samples, 0, sizeof samples);
    samples[128 * TILE_SIZE + 128] = 1;
    wavelet_forward(samples, room);
    for (int k = WAVELET_BANDS - 3; k < WAVELET_BANDS; k++) {
        const struct wavelet_band *b = &bands[k];
        assert_int_equal(b->level, 1);
        for (int y = 0; y < b->n; y++)
            for (int x = 0; x < b->n; x++) {
                int dy = abs(2 * y + b->tall - 128), dx = abs(2 * x + b->wide - 128);
                double v = b->tall ? (dy < 4 ? high_filter[dy] : 0) : dy < 5 ? low_filter[dy] : 0;
                double h = b->wide ? (dx < 4 ? high_filter[dx] : 0) : dx < 5 ? low_filter[dx] : 0;
                double got = (double)(b->norm * samples[(b->row + y) * TILE_SIZE + b->col + x]);
                check_near(fabs(got), fabs(v * h), 2e-6);
            }
    }
}

// What one coefficient adds to the squares of the samples: what the norms are for. The wavelet is
// not orthogonal: 0.967 to 1.086. Fails when a norm is another level's, or bands are mistaken.
static void norms_keep_the_power(void **state)
{
    (void)state;
    struct wavelet_band bands[WAVELET_BANDS];
    wavelet_bands(bands);
    for (int k = 0; k < WAVELET_BANDS; k++) {
        const struct wavelet_band *b = &bands[k];
        double sum = 0;
        memset(samples, 0, sizeof samples);
        samples[(b->row + b->n / 2) * TILE_SIZE + b->col + b->n / 2] = 1 / b->norm;
        wavelet_inverse(samples, room);
        for (int i = 0; i < SAMPLES; i++) sum += (double)samples[i] * (double)samples[i];
        check_near(sqrt(sum), 1, 0.09);
    }
}

static int skewed_symbol(struct check_random *r)
{
    int symbol = 0;
    while (symbol < SYMBOL_COUNT - 1 && check_random_range(r, 0, 1) < 0.6) symbol++;
    return symbol;
}

// Symbols and bits come back, and take at most 2 % over the entropy of their source. Fails when
// the table does not follow, when reader and writer follow differently.
static void symbols_come_back_at_their_entropy(void **state)
{
    (void)state;
    enum { COUNT = 100000 };
    static int symbols[COUNT];
    struct check_random random = {11};
    struct symbol_table table;
    double even[SYMBOL_COUNT], entropy = 0, rest = 1;
    for (int i = 0; i < SYMBOL_COUNT; i++) {
        double p = i < SYMBOL_COUNT - 1 ? rest * 0.4 : rest;
        rest -= p;
        entropy -= p * log2(p);
        even[i] = 1;
    }
    struct symbol_writer *w = symbol_writer_create();
    symbol_table_init(&table, even);
    for (int i = 0; i < COUNT; i++) {
        symbols[i] = skewed_symbol(&random);
        symbol_put(w, &table, symbols[i]);
        symbol_put_bits(w, (uint32_t)i, symbols[i]);
    }
    codec_blob body;
    size_t bits_at;
    assert_int_equal(symbol_writer_finish(w, &body, &bits_at), OK);
    print_message("%.4f bits a symbol, entropy %.4f\n", 8.0 * (double)bits_at / COUNT, entropy);
    assert_true(8.0 * (double)bits_at / COUNT < 1.02 * entropy);
    symbol_table_init(&table, even);
    struct symbol_reader r = symbol_reader_begin(body.data, body.size, bits_at);
    for (int i = 0; i < COUNT; i++) {
        assert_int_equal(symbol_get(&r, &table), symbols[i]);
        assert_int_equal(symbol_get_bits(&r, symbols[i]), i & ((1 << symbols[i]) - 1));
    }
    codec_blob_deinit(&body);
    symbol_writer_destroy(&w);
}

// However one-sided, every symbol keeps a place. Fails when a frequency can fall to 0.
static void every_symbol_keeps_a_place(void **state)
{
    (void)state;
    double even[SYMBOL_COUNT];
    for (int i = 0; i < SYMBOL_COUNT; i++) even[i] = i == 7 ? 1e9 : 1e-9;
    for (int only = 0; only < SYMBOL_COUNT; only++) {
        struct symbol_table t;
        symbol_table_init(&t, even);
        for (int i = 0; i < 5000; i++) {
            symbol_follow(&t, i % 4000 < 3000 ? only : (only + 5) % SYMBOL_COUNT);
            int sum = 0;
            for (int s = 0; s < SYMBOL_COUNT; s++) {
                assert_true(symbol_frequency(&t, s) >= 1);
                sum += symbol_frequency(&t, s);
            }
            assert_int_equal(sum, SYMBOL_TOTAL);
        }
    }
}

// Normal noise of the same strength in all bands: no code of any kind takes less than
// log2(strength / error) bits, and one that rounds each by itself takes 0.25 more at many bits.
// Fails when the states are not followed, when odd steps are left out, when the price of a bit is
// not looked at.
static void coefficients_are_near_the_least(void **state)
{
    (void)state;
    struct check_random random = {12};
    struct wavelet_band bands[WAVELET_BANDS];
    wavelet_bands(bands);
    for (int k = 0; k < WAVELET_BANDS; k++)
        for (int y = 0; y < bands[k].n; y++)
            for (int x = 0; x < bands[k].n; x++)
                samples[(bands[k].row + y) * TILE_SIZE + bands[k].col + x] =
                    (float)normal(&random) / bands[k].norm;
    static const float steps[] = {0.1f, 0.3f, 1};
    static const double over[] = {0.2, 0.2, 0.24};
    for (int i = 0; i < 3; i++) {
        struct bands_scale scale = {.step = steps[i]};
        struct symbol_writer *w = symbol_writer_create();
        assert_int_equal(bands_encode(samples, &scale, w, kept), OK);
        codec_blob body;
        size_t bits_at;
        assert_int_equal(symbol_writer_finish(w, &body, &bits_at), OK);
        struct symbol_reader r = symbol_reader_begin(body.data, body.size, bits_at);
        bands_decode(&r, &scale, back);
        assert_memory_equal(back, kept, sizeof kept);
        double sum = 0;
        for (int k = 0; k < WAVELET_BANDS; k++)
            for (int y = 0; y < bands[k].n; y++)
                for (int x = 0; x < bands[k].n; x++) {
                    int at = (bands[k].row + y) * TILE_SIZE + bands[k].col + x;
                    double off = (double)bands[k].norm * (double)(samples[at] - back[at]);
                    sum += off * off;
                }
        double bits = 8.0 * (double)body.size / SAMPLES, least = -log2(sqrt(sum / SAMPLES));
        print_message("step %g: %.3f bits, the least %.3f\n", (double)steps[i], bits, least);
        assert_true(bits > least && bits < least + over[i]);
        codec_blob_deinit(&body);
        symbol_writer_destroy(&w);
    }
}

// Levels without anything, numbers of every size, and none beyond the code. Fails when a symbol's
// plain bits are too few, or a level is left out that holds something.
static void numbers_of_every_size_come_back(void **state)
{
    (void)state;
    struct wavelet_band bands[WAVELET_BANDS];
    wavelet_bands(bands);
    for (int empty = 0; empty <= WAVELET_LEVELS; empty++) {
        memset(samples, 0, sizeof samples);
        for (int k = 0; k < WAVELET_BANDS; k++)
            for (int i = 0; i < 28 && (k == 0 || bands[k].level > empty); i += 1 + (k % 3)) {
                int at = (bands[k].row + i % 8) * TILE_SIZE + bands[k].col + i / 8;
                samples[at] = (float)((i % 2 ? -1 : 1) * ldexp(1, i - 2)) / bands[k].norm;
            }
        struct bands_scale scale = {.step = 1};
        struct symbol_writer *w = symbol_writer_create();
        assert_int_equal(bands_encode(samples, &scale, w, kept), OK);
        assert_int_equal(scale.empty, empty);
        codec_blob body;
        size_t bits_at;
        assert_int_equal(symbol_writer_finish(w, &body, &bits_at), OK);
        struct symbol_reader r = symbol_reader_begin(body.data, body.size, bits_at);
        bands_decode(&r, &scale, back);
        assert_memory_equal(back, kept, sizeof kept);
        for (int i = 0; i < SAMPLES; i++)
            check_near(back[i], samples[i], 3 + 1e-6 * fabs((double)samples[i]));
        codec_blob_deinit(&body);
        symbol_writer_clear(w);
        samples[9] = 0x1p27f;
        assert_int_equal(bands_encode(samples, &scale, w, kept), ERR_UNSUPPORTED);
        symbol_writer_destroy(&w);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_wavelet_goes_back),
        cmocka_unit_test(the_finest_bands_are_the_published_filters),
        cmocka_unit_test(norms_keep_the_power),
        cmocka_unit_test(symbols_come_back_at_their_entropy),
        cmocka_unit_test(every_symbol_keeps_a_place),
        cmocka_unit_test(coefficients_are_near_the_least),
        cmocka_unit_test(numbers_of_every_size_come_back),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
