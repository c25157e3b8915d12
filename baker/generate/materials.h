// SPDX-License-Identifier: GPL-3.0-or-later
// The city's materials: one enumerator and one row each, in the order in which they stand in the glTF file.
#pragma once

#include <cstdint>
#include <span>

#include "baker/scene/scene.h"

namespace zc::generate {

enum class Mat : std::uint16_t {
  kAsphaltWet,
  kAsphaltPuddle,
  kAsphaltPatch,
  kManholeIron,
  kLaneWhite,
  kConcreteSidewalk,
  kKerbStone,
  kConcreteWet,
  kStoneLight,
  kStonePolished,
  kGrass,
  kSoil,
  kBrickRed,
  kBrickBrown,
  kOchre,
  kSandstone,
  kPlasterWhite,
  kPlasterCream,
  kConcreteGrey,
  kConcreteDark,
  kPastelBlue,
  kPastelGreen,
  kPastelPink,
  kHouseYellow,
  kHouseCoral,
  kHouseTeal,
  kHouseBlue,
  kRoofSlate,
  kRoofTile,
  kRoofGravel,
  kRoofBitumen,
  kCopperGreen,
  kMetalCorrugated,
  kMetalMirror,
  kMetalDark,
  kMetalGalvanised,
  kGlassDark,
  kGlassBlue,
  kGlassMirror,
  kGlassBronze,
  kWindowBlind,
  kDoorWood,
  kDoorGreen,
  kAwningRed,
  kAwningBlue,
  kAwningCream,
  kTreeTrunk,
  kLeafDark,
  kLeafLight,
  kLeafAutumn,
  kTyreRubber,
  kPaintRed,
  kPaintBlue,
  kPaintWhite,
  kPaintBlack,
  kPaintSilver,
  kPaintYellow,
  kPaintGreen,
  kSignalRed,
  kSignalAmber,
  kSignalGreen,
  kWater,
  kLampGlass,
  kMonumentStone,
};

// Indexed by Mat.
std::span<const Material> city_materials();

}  // namespace zc::generate
