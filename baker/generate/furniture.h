// SPDX-License-Identifier: GPL-3.0-or-later
// Things in the street, each closed and standing on (a finger's breadth in) the ground at its origin; the local +x axis
// points to the road or, for cars, ahead.
// Units: metres. Thread-safe: no state.
#pragma once

#include "baker/generate/mesh_builder.h"
#include "baker/generate/rng.h"

namespace zc::generate {

struct Spot {
  Vec3 at;
  Vec2 heading = {1, 0};
};

void add_tree(MeshBuilder& mesh, Rng& rng, Vec3 at, double height_m, bool fine = true);
void add_lamp(MeshBuilder& mesh, const Spot& spot);
void add_traffic_light(MeshBuilder& mesh, const Spot& spot);  // shows its lights towards local -y
void add_bollard(MeshBuilder& mesh, Vec3 at);
void add_bench(MeshBuilder& mesh, const Spot& spot);
void add_bin(MeshBuilder& mesh, Vec3 at);
void add_bus_stop(MeshBuilder& mesh, const Spot& spot);
void add_car(MeshBuilder& mesh, Rng& rng, const Spot& spot);
void add_tyre_stack(MeshBuilder& mesh, Rng& rng, Vec3 at, int count);

}  // namespace zc::generate
