// Measurement 1: the map transforms and the placing of vertices in float, on the CPU and on the
// GPU, against long double. Prints the tables of tests/ACCURACY-transforms.md; fails when a bar is
// broken.
//   accuracy_transforms [--dense]
#include <stdlib.h>
#include <string.h>

#include "gpu/gpu_fixture.h"
#include "paper_figures.h"
#include "report.h"
#include "transform_sweep.h"

static const double PAPER_RANGE = M_PI / 48 * (1 - 1e-12);

static double texel(const struct map_error *e)
{
    return worse(worse(e->lon_texel, e->lon_rows), e->lat_texel);
}

static void join(struct map_error *all, const struct map_error *one)
{
    all->lon_texel = worse(all->lon_texel, one->lon_texel);
    all->lon_texel_at_pole = worse(all->lon_texel_at_pole, one->lon_texel_at_pole);
    all->lon_rows = worse(all->lon_rows, one->lon_rows);
    all->lat_texel = worse(all->lat_texel, one->lat_texel);
    all->metres = worse(all->metres, one->metres);
}

// Worst over the viewers at least `from` away from the poles.
static struct map_error of_level(const struct transform_sweep *s, int transform, int device,
                                 int level, double from)
{
    struct map_error all = {0};
    for (int k = 0; k < s->colatitudes; k++)
        if (s->colatitude[k] >= from) join(&all, &s->map[transform][device][k][level]);
    return all;
}

static struct map_error of_viewer(const struct transform_sweep *s, int transform, int device, int k,
                                  int first_level)
{
    struct map_error all = {0};
    for (int level = first_level; level <= LAST_LEVEL; level++)
        join(&all, &s->map[transform][device][k][level]);
    return all;
}

static void print_cell(struct map_error e)
{
    printf(" %.1e / %.1e |", texel(&e), e.metres);
}

static void print_levels(const struct transform_sweep *s)
{
    printf("\n#### By level: texels / metres\n\n| level | stable CPU | stable GPU | exact CPU | "
           "exact GPU | approx | blend GPU |\n|---|---|---|---|---|---|---|\n");
    for (int level = FIRST_LEVEL; level <= LAST_LEVEL; level++) {
        printf("| %d |", level);
        print_cell(of_level(s, STABLE, CPU, level, 0));
        print_cell(of_level(s, STABLE, GPU, level, 0));
        print_cell(of_level(s, EXACT, CPU, level, PAPER_RANGE));
        print_cell(of_level(s, EXACT, GPU, level, PAPER_RANGE));
        print_cell(of_level(s, APPROX, GPU, level, PAPER_RANGE));
        print_cell(of_level(s, BLEND, GPU, level, PAPER_RANGE));
        printf("\n");
    }
}

static void print_viewers(const struct transform_sweep *s)
{
    printf(
        "\n#### By the viewer's colatitude, north and south: texels / metres\n\n"
        "| colatitude (rad) | stable CPU | stable GPU | exact CPU | exact GPU | approx, level 10 "
        "on | blend GPU |\n|---|---|---|---|---|---|---|\n");
    for (int k = 0; k < s->colatitudes; k++) {
        printf("| %.4g |", s->colatitude[k]);
        print_cell(of_viewer(s, STABLE, CPU, k, FIRST_LEVEL));
        print_cell(of_viewer(s, STABLE, GPU, k, FIRST_LEVEL));
        print_cell(of_viewer(s, EXACT, CPU, k, FIRST_LEVEL));
        print_cell(of_viewer(s, EXACT, GPU, k, FIRST_LEVEL));
        print_cell(of_viewer(s, APPROX, GPU, k, 10));
        print_cell(of_viewer(s, BLEND, GPU, k, FIRST_LEVEL));
        printf("\n");
    }
}

// The paper's figure 13 for today's arc tangents, and the cancellation it does not show.
static void print_figure_13(const struct transform_sweep *s)
{
    int k = 0;
    while (fabs(s->colatitude[k] - 3 * M_PI / 8) > 1e-9) k++;
    printf("\n#### Figure 13: texels of longitude by atan(y, x) and of latitude by acos(z) - "
           "theta_v, colatitude 3 pi/8\n\n| level | atan CPU | atan GPU | atan ours | acos CPU | "
           "acos GPU | latitude ours |\n|---|---|---|---|---|---|---|\n");
    for (int level = FIRST_LEVEL; level <= LAST_LEVEL; level++) {
        const struct map_error *cpu = &s->map[EXACT][CPU][k][level],
                               *gpu = &s->map[EXACT][GPU][k][level],
                               *ours = &s->map[STABLE][GPU][k][level];
        printf("| %d | %.1e | %.1e | %.1e | %.1e | %.1e | %.1e |\n", level, cpu->lon_texel,
               gpu->lon_texel, ours->lon_texel, cpu->lat_texel, gpu->lat_texel, ours->lat_texel);
    }
}

static void print_positions(const struct transform_sweep *s, int eye, const char *title)
{
    static const char *const bins[] = {"1 km", "10 km", "100 km", "1000 km", "beyond"};
    printf("\n#### Positions, %s: metres / share of the distance\n\n| distance up to | CPU | GPU | "
           "CPU, "
           "less the vertex's own rounding | GPU |\n|---|---|---|---|---|\n",
           title);
    for (int b = 0; b < DISTANCE_BINS; b++) {
        printf("| %s |", bins[b]);
        for (int c = 0; c < 2 * DEVICES; c++) {
            const struct position_error *e =
                c < DEVICES ? &s->position[eye][c] : &s->stored[eye][c - DEVICES];
            printf(" %.2e / %.1e |", e->metres[b], e->relative[b]);
        }
        printf("\n");
    }
}

static int check_positions(const struct position_error e[DEVICES], const char *what)
{
    double metres = 0, relative = 0;
    char near[120], far[120];
    for (int d = 0; d < DEVICES; d++)
        for (int b = 0; b < DISTANCE_BINS; b++) {
            if (b < 2) metres = worse(metres, e[d].metres[b]);
            else relative = worse(relative, e[d].relative[b]);
        }
    snprintf(near, sizeof near, "position, %s, within 10 km, m", what);
    snprintf(far, sizeof far, "position, %s, beyond, share of the distance", what);
    return bar_at_most(near, metres, 1e-3) + bar_at_most(far, relative, 3e-7);
}

// Stable and the paper's forms on the same vertices: the ring that begins level 10.
static int check_ratio(const struct transform_sweep *s)
{
    struct map_error stable = of_level(s, STABLE, GPU, 10, PAPER_RANGE),
                     acos_form = of_level(s, EXACT, GPU, 10, PAPER_RANGE),
                     approx = of_level(s, APPROX, GPU, 10, PAPER_RANGE);
    printf("- level 10, the paper's latitudes: approx %.3g times, exact %.3g times the error of "
           "stable (texels)\n",
           texel(&approx) / texel(&stable), texel(&acos_form) / texel(&stable));
    return bar_at_least("level 10, approx : stable, all azimuths", texel(&approx) / texel(&stable),
                        500);
}

static int check_transforms(const struct transform_sweep *s)
{
    struct map_error all = {0}, pixel = {0};
    for (int level = FIRST_LEVEL; level <= LAST_LEVEL; level++) {
        for (int d = 0; d < DEVICES; d++) {
            struct map_error e = of_level(s, STABLE, d, level, 0);
            join(&all, &e);
        }
        if (level > 1) join(&pixel, &s->pixel[level]);
    }
    printf("\n%ld vertices, each on the CPU and on the GPU\n\n", s->vertices);
    int broken = bar_at_most("stable, texels", texel(&all), 1e-3);
    printf("- the same within %d rows of a pole, where a column is a sliver of a row: %.2g "
           "columns; on "
           "the ground %.2g rows\n",
           POLE_ROWS, all.lon_texel_at_pole, all.lon_rows);
    broken += bar_at_most("stable with v from n and e, level 2 on, texels", texel(&pixel), 1e-3);
    printf("- the same in level 1, to a quarter turn: %.2g texels\n", texel(&s->pixel[1]));
    broken += check_positions(s->position[OVER_FOCUS], "camera over the focus");
    broken += check_positions(s->stored[BESIDE_FOCUS],
                              "focus 15 km beside, less the vertex's own rounding");
    return broken + check_ratio(s);
}

static int measure(bool dense)
{
    static struct transform_sweep s;
    if (transform_sweep_run(dense, &s)) return EXIT_FAILURE;
    print_levels(&s);
    print_viewers(&s);
    print_positions(&s, OVER_FOCUS, "camera over the focus");
    print_positions(&s, BESIDE_FOCUS, "focus 15 km beside the camera");
    print_figure_13(&s);
    int broken = paper_figures_print() + check_transforms(&s);
    printf("\n%d bars broken\n", broken);
    return broken ? EXIT_FAILURE : EXIT_SUCCESS;
}

int main(int argc, char **argv)
{
    bool dense = argc == 2 && !strcmp(argv[1], "--dense");
    if (argc > 2 || (argc == 2 && !dense)) {
        fprintf(stderr, "accuracy_transforms: \"%s\" is not an option; there is --dense\n",
                argv[1]);
        return EXIT_FAILURE;
    }
    int rc = gpu_fixture_open();
    return rc ? rc : gpu_fixture_close(measure(dense));
}
