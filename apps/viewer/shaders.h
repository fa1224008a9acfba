// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// GLSL 3.30 sources of every pass. ShaderProgram adds the version and what is defined: DETAIL,
/// GLOW, OCCLUSION and SHADOWS as a RenderQuality says, SKIN in programs that draw surfaces,
/// DEPTH_ONLY in those that need nothing but places.

namespace cholecystectomy {

// scene_shaders.cpp
extern const char* const kSceneVertexShader;  ///< a DrawList in all passes over the scene
extern const char* const kSkinVertexShader;   ///< SurfaceBuffers in the same passes
extern const char* const kMaskVertexShader;   ///< what the round picture leaves out
inline constexpr int kMaskPoints = 98;

// lighting_shaders.cpp: the picture in linear light: the functions, then one of the three.
extern const char* const kLightingFunctions;
extern const char* const kTissueFragmentShader;
extern const char* const kToolFragmentShader;
extern const char* const kSmokeFragmentShader;

// screen_shaders.cpp
extern const char* const kScreenVertexShader;      ///< one triangle over the whole picture
extern const char* const kEmptyFragmentShader;     ///< depth alone, for the shadow map
extern const char* const kGeometryFragmentShader;  ///< normal and depth, for the occlusion
extern const char* const kOcclusionFragmentShader;
extern const char* const kOcclusionBlurFragmentShader;
extern const char* const kGlowFragmentShader;   ///< one direction of the glow around highlights
extern const char* const kScopeFragmentShader;  ///< exposure, vignette and the round mask

}  // namespace cholecystectomy
