// Which rectangle of the map a clipmap level holds: pure arithmetic, no state, so that the same
// viewer always has the same windows whatever path led there.
//
// The map of zoom l has 256 2^l sample rows (row 0 northmost, step pi / (256 2^l)). A window
// samples it in columns of step 2 pi / (cols 2^k): its width is the share 2 pi / 2^k of the circle,
// k in [0, l], the narrowest power of two that holds the ring. Window columns are numbered on that
// step from longitude -pi, so column j of share k lies at longitude -pi + (j + 1/2) step, and j
// counts modulo cols 2^k. Rows beyond a pole hold the opposite meridian: row -1 - r at longitude
// lon is row r at lon + pi. A full-circle window (k = 0) holds every column and never moves
// sideways. A sample lives in the texture at (row mod rows, col mod cols).
//
// The margin, (rows - diameter_rows) / 2 samples on each side of the ring, of columns at most
// diameter_rows / 16, has room for the bilinear footprint (1), the snapping (1/2), geodetic against
// reduced latitude (up to A/B - 1 of the radius) and for data that lags behind the viewer. Rows are
// clipped at the margin beyond a pole: there a window stands still.
//
// Pure functions. Any thread.
#ifndef PERIGEE_CLIPMAP_WINDOW_H
#define PERIGEE_CLIPMAP_WINDOW_H

#include <stdbool.h>
#include <stdint.h>

// Shape of the windows of one layer. The ring of level i >= 1 (radius pi 2^-i) needs
// `diameter_rows` rows across its diameter: zoom l = i - 1 + log2(diameter_rows / 256); level 0
// holds the whole map at the zoom of level 1.
typedef struct window_shape {
    int rows;          // texture rows, diameter_rows + 2 * margin
    int cols;          // texture columns, a power of two
    int diameter_rows; // a power of two >= 256
} window_shape;

// Colour: 1056 x 1024 for 1024 rows across. Heights: 336 x 512 for 256 rows across, and in that
// proportion for more: a ring is sampled by its window a little before it fills it
// (src/render/windows.c, LEAD).
#define WINDOW_COLOR ((window_shape){1056, 1024, 1024})

static inline window_shape window_height_shape(int diameter_rows)
{
    return (window_shape){diameter_rows + diameter_rows / 16 * 5, 2 * diameter_rows, diameter_rows};
}

// A half-open rectangle of window samples: rows [row0, row1), columns [col0, col1), col1 - col0 <=
// cols. Empty when row0 >= row1 or col0 >= col1.
typedef struct window_rect {
    int64_t row0, row1, col0, col1;
} window_rect;

typedef struct window {
    int level;
    int zoom;         // l
    int share;        // k
    window_rect rect; // always `rows` x `cols` samples
    int derived;      // levels in a row, this the last, that are made from the one before; 0: from
                      // tiles. window_at() leaves it 0
} window;

// The window of a level for a focus at geodetic latitude and longitude (rad; any finite longitude).
// ring_bound: by how much the geodetic radius may exceed the reduced one: A/B of the ellipsoid. It
// also gives the reduced latitude, on which the ring's longitude span depends. The ring and its
// bilinear footprint lie inside while diameter_rows / 2 * (ring_bound - 1) + 3/2 <= margin: up to
// an A/B of 1.11 for the heights above, of 1.028 for the colour.
window window_at(const window_shape *shape, int level, double lat, double lon, double ring_bound);

// Steps between samples, rad.
double window_step_lat(const window *w);
double window_step_lon(const window_shape *shape, const window *w);

// How far a window's columns are on the way to the share of half as many: 0, rising to 1 where
// window_at() goes over to that share as its focus nears a pole. lat: of the focus, which may have
// moved on.
double window_widening(const window_shape *shape, const window *w, double lat, double ring_bound);

// Continuous sample coordinates of a place: sample (row, col) has its centre at row + 1/2, col +
// 1/2. col is on the copy of the circle nearest to the rectangle's middle.
void window_coordinates(const window_shape *shape, const window *w, double lat, double lon,
                        double *row, double *col);

// Texel of a sample along an axis of `size` texels: sample mod size, never negative.
int window_texel(int64_t sample, int size);

bool window_rect_empty(window_rect r);
bool window_rect_equal(window_rect a, window_rect b);
window_rect window_rect_intersect(window_rect a, window_rect b);

// rect moved by whole turns of the given share so that its middle is as near to that of `near` as
// can be.
window_rect window_rect_turned(const window_shape *shape, int share, window_rect rect,
                               window_rect near);

// What of a window `to` can be made of a rectangle of samples of share `from`, one more or one less
// than the window's: a column of each whole pair; or two of each column, by the
// cubic through it and the neighbours, one on the one side and two on the other. A window of the
// whole circle begins at longitude -pi: of a rectangle across it the smaller part is lost. In
// columns of `to`, inside its rect.
window_rect window_rect_recast(const window_shape *shape, int from, window_rect rect,
                               const window *to);

// The samples of the next coarser window, of half the rows and columns, of which a rectangle's are
// made by the four-point filter.
window_rect window_rect_parents(window_rect rect);

// target minus held, as at most 4 disjoint rectangles: first columns beside `held` on its rows,
// then whole rows. Both of the same share; `held` is empty or inside `target`. Returns the count.
int window_rect_missing(window_rect target, window_rect held, window_rect out[4]);

#endif
