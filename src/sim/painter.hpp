#pragma once

#include <cstdint>

#include "src/sim/random.hpp"
#include "src/sim/texture.hpp"

namespace pled::sim {

/// What a surface looks like.
enum class Finish : std::uint8_t {
  kWall,
  kFloor,
  kCeiling,
  kCrate,
  kCloth,
  kAsphalt,   ///< with markings; a square of 41 m that repeats
  kPavement,  ///< slabs
  kFacade,    ///< windows, signs at the foot
  kSkyline,   ///< houses far away
  kSky,
  kCarSide,  ///< doors, wheels
  kCarEnd,   ///< lamps, number plate
  kCarTop,
  kGlass,
  kBusSide,  ///< windows in a row, a stripe, notices below
  kPebbles,  ///< round spots, from 3 texels to 10 in radius
  kStripes,  ///< patches of stripes in all directions, 5 to 12 texels wide
};

/// Reflectances above this are lamps: they shine whatever the light.
inline constexpr float kLampFrom = 0.96F;

/// An empty texture for a face of width x height metres, of texels of `texel_m`, or coarser where
/// the finish has nothing finer to show.
[[nodiscard]] Texture make_texture(Finish finish, double width_m, double height_m, double texel_m);

/// Paints the finest level of `texture` from nothing but the random numbers given
/// and builds the coarser ones. Patterns have sizes from 2 cm to a metre, so that
/// there are corners to see from any distance in a room; out of doors to ten metres.
void paint(Texture& texture, Finish finish, Random random);

}  // namespace pled::sim
