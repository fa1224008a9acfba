// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The tools and other bodies at a vertex of the vertex-block method, on a host.

#include "pbdsurg/base/types.h"

#include "lib/solver/methods/grip.h"
#include "lib/solver/methods/surface_contacts.h"
#include "lib/solver/methods/touch_response.h"
#include "lib/solver/methods/vertex_moves.h"
#include "lib/solver/program/step_scratch.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_state.h"

namespace pbdsurg {

/// What tools do at one vertex, as move_held() takes it; and what other bodies do.
class HeldVertex {
 public:
  HeldVertex(const StepContext& step, const SplitPosition& position, Index first)
      : step_(step), position_(position), first_(first) {}

  template <class Visit>
  void for_each_grasp(const Visit& visit) const {
    for_each([&](const VertexHold& hold) {
      if (hold.kind == HoldKind::grasp) {
        Attachment& attachment = step_.copy.tools[hold.tool].attachments[hold.entry];
        visit(Grasp{attachment, position_, step_.copy.grasp_compliance(attachment)});
      } else if (hold.kind == HoldKind::grip) {
        const ToolGrip& grip = step_.copy.tools[hold.tool].grip;
        const GripPoint& point = grip.points[hold.entry];
        const float share = 1 / point.at.weights[hold.corner];
        visit(Grip{share * way_to_jaws(step_, grip, point),
                   share * share * compliance_of(step_.copy, grip)});
      }
    });
  }

  template <class Visit>
  void for_each_contact(const Visit& visit) const {
    for_each([&](const VertexHold& hold) {
      if (hold.kind == HoldKind::contact) {
        visit(Touch{step_.copy.tools[hold.tool].contacts[hold.entry], position_});
      }
    });
  }

  /// Adds the surface contacts of the vertex, and those with other bodies, to its energy.
  void add_surface_contacts(float inverse_dt_squared, VertexEnergy<float>& energy) const {
    for_each([&](const VertexHold& hold) {
      if (hold.kind == HoldKind::touch) {
        add_touch(step_, step_.copy.touches.contacts[hold.entry], hold.corner, inverse_dt_squared,
                  energy);
      } else if (hold.kind == HoldKind::surface_contact) {
        const ToolState& tool = step_.copy.tools[hold.tool];
        add_surface_contact(step_, tool.surface_contacts[hold.entry], hold.corner, tool,
                            inverse_dt_squared, energy);
      }
    });
  }

 private:
  struct Grasp {
    Attachment& attachment;
    const SplitPosition& position;
    float own_compliance;

    [[nodiscard]] Vec3<float> target() const { return position.way_to(load(attachment.target)); }
    [[nodiscard]] float compliance() const { return own_compliance; }
    void set_multiplier(const Vec3<float>& multiplier) const {
      attachment.multiplier = {multiplier.x, multiplier.y, multiplier.z};
    }
  };

  // A corner of a point that jaws draw: where the corner would take the point to its anchor by
  // itself. Multipliers are for answer_grips().
  struct Grip {
    Vec3<float> way;
    float own_compliance;

    [[nodiscard]] Vec3<float> target() const { return way; }
    [[nodiscard]] float compliance() const { return own_compliance; }
    void set_multiplier(const Vec3<float>& /*multiplier*/) const {}
  };

  struct Touch {
    Contact& contact;
    const SplitPosition& position;

    [[nodiscard]] Vec3<float> normal() const { return load(contact.normal); }
    [[nodiscard]] float offset() const { return position.height_to(normal(), contact.offset); }
    [[nodiscard]] float multiplier() const { return contact.multiplier; }
    void set_multiplier(float multiplier) const { contact.multiplier = multiplier; }
  };

  template <class Visit>
  void for_each(const Visit& visit) const {
    const std::vector<VertexHold>& holds = step_.scratch.holds;
    for (Index h = first_; h != kInvalidIndex; h = holds[h].next) {
      visit(holds[h]);
    }
  }

  const StepContext& step_;
  SplitPosition position_;
  Index first_;
};

}  // namespace pbdsurg
