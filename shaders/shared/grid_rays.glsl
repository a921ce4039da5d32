// The persistent grid's rays: from a place on the screen to the place on the planet over which its vertex stands. In double
// on both sides: near the limb and far from the focus a float would lose the ground. C defines GRID(m), a member of the
// block, GRID_PARAM and GRID_PASS, the block handed from function to function, which GLSL has as a buffer.
//   source  Livny et al. 2008, 3.1 to 3.3; its base plane is here the ellipsoid, met as the unit sphere
#ifndef SHARED_GRID_RAYS
#define SHARED_GRID_RAYS

#define GRID_BEND 0.5 /* share of half a picture that all outside it takes, up to the axis of the rows or columns */

struct grid_direction {
    double u, e, n;
};

// Where a row stands, as a number whose equal steps are equal steps of the grid: in the picture the distance from its
// middle, denser there by `denser`; outside it the way along the straight line to the axis. The direction is
// ahead * (direction of the column) + above * (row axis).
GRID_SHARED void grid_unwarp(double w, double half_size, double denser, GRID_OUT(double) ahead, GRID_OUT(double) above)
{
    double size = w < 0.0 ? -w : w;
    if (size <= half_size) {
        double v = w / half_size;
        GRID_SET(ahead) = 1.0;
        GRID_SET(above) = w * (1.0 - denser + denser * v * v);
    } else {
        GRID_SET(ahead) = 1.0 - (size - half_size) / (GRID_BEND * half_size);
        GRID_SET(above) = w < 0.0 ? -half_size : half_size;
    }
}

// The row that stands where a column crosses the limb: the nearest, but none of the ends.
GRID_SHARED int grid_limb_row(double low, double step, double limb, int rows)
{
    if (!(limb < 1e29) || rows < 3 || step <= 0.0) return -1;
    int row = int_of((limb - low) / step + 0.5);
    return row < 1 ? 1 : row > rows - 2 ? rows - 2 : row;
}

// Where row `row` of `rows` between `low` and `high` stands.
GRID_SHARED double grid_row(double low, double high, double limb_low, double limb_high, int row, int rows)
{
    double step = (high - low) / double_of(rows - 1);
    if (row == grid_limb_row(low, step, limb_low, rows)) return limb_low;
    if (row == grid_limb_row(low, step, limb_high, rows)) return limb_high;
    return row == rows - 1 ? high : low + step * double_of(row);
}

// Height of the base that a ray is thrown onto, by the cotangent down / side of its angle from the axis: no ground that it
// can meet is lower. It falls with the angle, so that rays side by side stay in order on the ground.
GRID_SHARED double grid_base(GRID_PARAM double down, double side)
{
    int last = int_of(GRID(base)[0][2]) - 1;
    if (down <= GRID(base)[0][0] * side) return GRID(base)[0][1];
    int i = 1;
    while (i <= last && down > GRID(base)[i][0] * side) i++;
    if (i > last) return GRID(base)[last][1];
    double c = down / side, from = GRID(base)[i - 1][0];
    double share = (c - from) / (GRID(base)[i][0] - from);
    return GRID(base)[i - 1][1] + share * (GRID(base)[i][1] - GRID(base)[i - 1][1]);
}

// On a plane: the place's coordinates, no farther from the camera than the map's farthest corner. Else:
// unit vector of the place under which the ray in a direction (any length) meets its base. A base at height g is met by
// lowering the camera by g, which keeps verticals vertical. A ray above the limb has no place of its own: it gets one
// behind the limb, farther the higher it passes, up to where the grid ends.
//   source  t from |C + t D| = 1: t = (C C - 1) / (b + sqrt(b b - D D (C C - 1))), b = -C D; nothing cancels
//   edges   on the limb the root is 0, and both branches give its point
GRID_SHARED grid_direction grid_foot(GRID_PARAM double u, double e, double n)
{
    double dd = u * u + e * e + n * n;
    double down = -(u * GRID(axis)[0] + e * GRID(axis)[1] + n * GRID(axis)[2]);
    double su = u + down * GRID(axis)[0], se = e + down * GRID(axis)[1], sn = n + down * GRID(axis)[2];
    double side = sqrt(su * su + se * se + sn * sn);
    double k = (GRID(axis)[3] - grid_base(GRID_PASS down, side)) * GRID(up)[3];
    if (GRID(base)[0][3] == 0.0) { // a plane
        double least = GRID(limb)[0] * side, t = k / (down < least ? least : down);
        grid_direction on;
        on.u = 0.0;
        on.e = GRID(foot)[1] + t * e;
        on.n = GRID(foot)[2] + t * n;
        return on;
    }
    double cu = GRID(foot)[0] + k * GRID(up)[0], ce = GRID(foot)[1] + k * GRID(up)[1],
           cn = GRID(foot)[2] + k * GRID(up)[2];
    double kk = k * (2.0 * GRID(foot)[3] + k);
    double b = -(cu * u + ce * e + cn * n), root = b * b - dd * kk;
    double pu, pe, pn;
    if (b > 0.0 && root >= 0.0) {
        double t = kk / (b + sqrt(root));
        pu = cu + t * u;
        pe = ce + t * e;
        pn = cn + t * n;
    } else {
        double range = GRID(limb)[0] - GRID(limb)[1];
        double q = range > 0.0 ? (GRID(limb)[0] - down / side) / range : 0.0;
        double past = (q < 0.0 ? 0.0 : q > 1.0 ? 1.0 : q) * GRID(limb)[2];
        double along = (GRID(limb)[0] + past) / side, out_of = 1.0 - past * GRID(limb)[0];
        pu = along * su + out_of * GRID(axis)[0];
        pe = along * se + out_of * GRID(axis)[1];
        pn = along * sn + out_of * GRID(axis)[2];
    }
    double size = sqrt(pu * pu + pe * pe + pn * pn);
    grid_direction p;
    p.u = pu / size;
    p.e = pe / size;
    p.n = pn / size;
    return p;
}

// Level of detail of a vertex: `fineness` is the spacing of level 0's samples over the distance to the farthest neighbour,
// `limit` the finest (continuous) level that reaches here. The whole level whose samples are no farther apart than the
// vertices, and the share of the next coarser: 0 where the two spacings agree, growing linearly to 1 where the coarser's does.
//   source  Livny et al. 2008, eq. 6, 7
GRID_SHARED void grid_level(float fineness, float limit, GRID_OUT(int) level, GRID_OUT(float) coarser)
{
    float fine = log2(fineness);
    fine = fine > limit ? limit : fine;
    fine = fine > 0.0f ? fine : 0.0f;
    float whole = ceil(fine), share = exp2(whole - fine) - 1.0f;
    GRID_SET(level) = int_of(whole);
    GRID_SET(coarser) = whole > 0.0f ? share : 0.0f;
}

#endif
