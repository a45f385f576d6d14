#pragma once

#include "src/sim/random.hpp"
#include "src/sim/texture.hpp"

namespace pled::sim {

/// What a surface looks like.
enum class Finish { kWall, kFloor, kCeiling, kCrate, kCloth };

/// Paints the finest level of `texture` from nothing but the random numbers given
/// and builds the coarser ones. Patterns have sizes from 2 cm to a metre, so that
/// there are corners to see from any distance in a room.
void paint(Texture& texture, Finish finish, Random random);

}  // namespace pled::sim
