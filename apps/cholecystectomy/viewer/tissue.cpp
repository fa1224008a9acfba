// SPDX-License-Identifier: Apache-2.0
#include "viewer/tissue.h"

namespace cholecystectomy {

TissueAppearance appearance_of(Tissue tissue) {
  TissueAppearance look;
  switch (tissue) {
    case Tissue::liver:
      look.color = {0.53f, 0.28f, 0.24f};
      look.mottle = {0.46f, 0.225f, 0.195f};
      look.gloss = 0.75f;
      look.detail_size = 0.0035f;
      look.relief = 0.16f;
      break;
    case Tissue::gallbladder:
      look.color = {0.62f, 0.68f, 0.56f};
      look.mottle = {0.47f, 0.58f, 0.52f};
      look.gloss = 0.9f;
      look.detail_size = 0.005f;
      look.relief = 0.16f;
      look.vessels = 0.75f;
      break;
    case Tissue::fat:
      look.color = {0.95f, 0.82f, 0.52f};
      look.mottle = {0.92f, 0.74f, 0.42f};
      look.gloss = 0.7f;
      look.detail_size = 0.0035f;
      look.relief = 0.2f;
      look.lobules = 1;
      look.vessels = 0.25f;
      break;
    case Tissue::artery:
      look.color = {0.74f, 0.30f, 0.26f};
      look.mottle = {0.62f, 0.20f, 0.18f};
      look.gloss = 0.8f;
      look.detail_size = 0.002f;
      look.relief = 0.15f;
      break;
    case Tissue::duct:
      look.color = {0.80f, 0.78f, 0.52f};
      look.mottle = {0.70f, 0.70f, 0.44f};
      look.gloss = 0.8f;
      look.detail_size = 0.002f;
      look.relief = 0.15f;
      look.vessels = 0.3f;
      break;
    case Tissue::membrane:
      look.color = {0.92f, 0.83f, 0.76f};
      look.mottle = {0.88f, 0.66f, 0.60f};
      look.gloss = 0.9f;
      look.opacity = 0.45f;
      look.detail_size = 0.003f;
      look.relief = 0.25f;
      look.vessels = 0.3f;
      break;
    case Tissue::abdominal_wall:
      look.color = {0.80f, 0.52f, 0.47f};
      look.mottle = {0.72f, 0.40f, 0.37f};
      look.gloss = 0.55f;
      look.detail_size = 0.010f;
      look.relief = 0.3f;
      look.vessels = 0.5f;
      break;
  }
  return look;
}

}  // namespace cholecystectomy
