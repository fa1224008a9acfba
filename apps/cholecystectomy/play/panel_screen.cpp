// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/panel_screen.h"

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

namespace cholecystectomy {

PanelScreen::PanelScreen(Window& window, const Panels& /*panels*/) : window_(window) {
  ImGui_ImplGlfw_InitForOpenGL(window.handle(), true);
  ImGui_ImplOpenGL3_Init("#version 330 core");
}

PanelScreen::~PanelScreen() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
}

void PanelScreen::begin(Panels& panels, double text_scale) {
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();  // the size of the display
  if (panels.fit(window_.scale(), text_scale)) {
    ImGui_ImplOpenGL3_DestroyFontsTexture();
    ImGui_ImplOpenGL3_CreateFontsTexture();
  }
}

void PanelScreen::draw() {
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

}  // namespace cholecystectomy
