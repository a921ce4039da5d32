// The paper's own forms (Clasen & Hege 2006, eq. 11, 14) on the sphere: its figure 12, its bound of
// 0.001 and where that ends, in long double, beside the stable form in float.
//
// Pure functions. Any thread.
#ifndef PERIGEE_TESTS_PAPER_FIGURES_H
#define PERIGEE_TESTS_PAPER_FIGURES_H

#include "geo/ring_truth.h"

// 1 - approximated / exact of the longitude, viewer at `colatitude`, ring at `angle`, azimuth east
// of north: what figure 12 shows for the azimuth pi/2.
exact paper_relative_error(exact colatitude, exact angle, exact azimuth);

// Largest over 720 azimuths of the ring: longitude error over the largest longitude of the ring.
exact paper_ring_error(exact colatitude, exact angle);

// |got / exact - 1| of the longitude by the stable form in float at the azimuth pi/2.
double stable_relative_error(double colatitude, double angle);

// Prints figure 12 and where the bound ends as tables. Returns the bars broken.
int paper_figures_print(void);

#endif
