// Colour of a hit by the rules of shaders/shade/ground.glsl without its air. Any thread, each with
// its own reader.
#ifndef PERIGEE_REFERENCE_LIGHT_H
#define PERIGEE_REFERENCE_LIGHT_H

#include "reference/ray.h"

// dir: the ray; sun: unit, ECEF; pixel: metres that a pixel is wide at distance 1. Linear light.
void light_at(struct field_reader *reader, const ray_hit *hit, dvec3 dir, dvec3 sun, double pixel,
              double rgb[3]);

#endif
