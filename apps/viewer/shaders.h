// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// GLSL 3.30 sources of every pass, in the order in which they run.

namespace cholecystectomy {

extern const char* const kSceneVertexShader;       ///< the geometry of all passes over the scene
extern const char* const kScreenVertexShader;      ///< one triangle over the whole picture
extern const char* const kEmptyFragmentShader;     ///< depth alone, for the shadow map
extern const char* const kGeometryFragmentShader;  ///< normal and depth, for the occlusion
extern const char* const kOcclusionFragmentShader;
extern const char* const kOcclusionBlurFragmentShader;

// The picture in linear light: the functions, then one of the three.
extern const char* const kLightingFunctions;
extern const char* const kTissueFragmentShader;
extern const char* const kToolFragmentShader;
extern const char* const kSmokeFragmentShader;

extern const char* const kGlowFragmentShader;   ///< one direction of the glow around highlights
extern const char* const kScopeFragmentShader;  ///< exposure, vignette and the round mask

}  // namespace cholecystectomy
