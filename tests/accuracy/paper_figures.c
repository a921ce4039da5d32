#include "paper_figures.h"

#include "geo/shared.h"
#include "report.h"

// Eq. 11 as printed.
static exact stretch(exact colatitude)
{
    exact q = colatitude / PI_EXACT - 0.5L;
    return 1 + 1 / PI_EXACT / (0.25L - q * q) - q * q / 6 - 4 / PI_EXACT;
}

// Eq. 9 and 10, azimuth from north.
static exact longitude(exact colatitude, exact angle, exact azimuth)
{
    exact north = sinl(angle) * cosl(azimuth), east = sinl(angle) * sinl(azimuth);
    return atan2l(east, sinl(colatitude) * cosl(angle) - cosl(colatitude) * north);
}

exact paper_relative_error(exact colatitude, exact angle, exact azimuth)
{
    exact approximated = sinl(angle) * sinl(azimuth) * stretch(colatitude);
    return 1 - approximated / longitude(colatitude, angle, azimuth);
}

exact paper_ring_error(exact colatitude, exact angle)
{
    exact worst = 0, largest = 0;
    for (int i = 1; i < 720; i++) {
        exact azimuth = PI_EXACT * i / 720, want = longitude(colatitude, angle, azimuth);
        exact got = sinl(angle) * sinl(azimuth) * stretch(colatitude);
        worst = fmaxl(worst, fabsl(got - want));
        largest = fmaxl(largest, want);
    }
    return worst / largest;
}

double stable_relative_error(double colatitude, double angle)
{
    double half = sin(angle / 2);
    float dlon, dlat;
    map_transform_stable_f(0, (float)sin(angle), (float)(2 * half * half), (float)sin(colatitude),
                           (float)cos(colatitude), 1, &dlon, &dlat);
    return (double)fabsl(dlon / longitude(colatitude, angle, PI_EXACT / 2) - 1);
}

static double figure_error(double colatitude, double angle)
{
    return (double)fabsl(paper_relative_error(colatitude, angle, PI_EXACT / 2));
}

// Where figure_error first passes 0.001 on the way from `inside` (it is below there) to `outside`.
static double end_of_bound(double colatitude, double angle, double to_colatitude, double to_angle)
{
    double low = 0, high = 1;
    for (int i = 0; i < 100; i++) {
        double t = (low + high) / 2;
        double c = colatitude * pow(to_colatitude / colatitude, t);
        double a = angle * pow(to_angle / angle, t);
        if (figure_error(c, a) <= 1e-3) low = t;
        else high = t;
    }
    return low;
}

// `stable`: worst of the stable form over the paper's range.
static void print_figure(double angle, double stable)
{
    static const int parts[] = {200, 96, 64, 56, 48, 32, 16, 8, 4, 3, 2};
    printf("\n| viewer's colatitude | 1 - approximated/exact, eq. 11 | the same over all azimuths "
           "| times the worst of stable in fp32 |\n|---|---|---|---|\n");
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        double c = M_PI / parts[i];
        printf("| pi/%d%s | %.2e | %.1e | %.0f |\n", parts[i], parts[i] > 48 ? " (outside)" : "",
               (double)paper_relative_error(c, angle, PI_EXACT / 2),
               (double)paper_ring_error(c, angle), figure_error(c, angle) / stable);
    }
}

static void print_ends(double angle)
{
    double t = end_of_bound(M_PI / 48, angle, M_PI / 480, angle);
    printf("\nAt pi/1024 the bound ends at the colatitude pi/%.1f.\n", 48 * pow(10, t));
    static const int parts[] = {48, 16, 4, 2};
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++) {
        double c = M_PI / parts[i], end = angle * pow(1024, end_of_bound(c, angle, c, M_PI));
        printf("At the colatitude pi/%d it ends at a ring of pi/%.3g.\n", parts[i], M_PI / end);
    }
}

int paper_figures_print(void)
{
    double angle = M_PI / 1024, paper = 0, stable = 0, around = 0;
    for (int i = 0; i <= 4000; i++) {
        double c = M_PI / 48 + (M_PI / 2 - M_PI / 48) * i / 4000;
        paper = worse(paper, figure_error(c, angle));
        stable = worse(stable, stable_relative_error(c, angle));
        if (i % 100 == 0) around = worse(around, (double)paper_ring_error(c, angle));
    }
    printf("\n#### Figure 12: eq. 11 at the ring pi/1024, azimuth pi/2, on the sphere\n");
    print_figure(angle, stable);
    print_ends(angle);
    printf("\nOver pi/48 <= colatitude <= pi/2: eq. 11 at the azimuth pi/2 %.2e, over all azimuths "
           "%.2g (the paper gives no\nbound there); stable %.2e.\n\n",
           paper, around, stable);
    int broken = bar_at_most("the paper's bound, in its own range", paper, 1e-3);
    return broken + bar_at_least("stable : paper at pi/1024, worst of each", paper / stable, 500);
}
