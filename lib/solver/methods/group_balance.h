// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How pieces of tissue move as rigid bodies that touch surfaces and each other, on a CPU or a
/// device. What a contact gives to one, it takes from the other.
///
/// With the momentum P that sweeps have given them (momentum.h), M their masses and inertias, and f
/// what a contact answers to gap and slip (contact_answer.h), they are to move by the twists q with
///
///     P + M q = sum J^T f(q)
///
/// where J q is how the point of a contact goes. This is Newton's method with the contacts' springs
/// in the matrix, so a firm contact does not throw a piece, and with a step that is cut where
/// contacts begin to push or to slide (semismooth: Alart and Curnier 1991). In double precision.

#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

#include "lib/solver/methods/rigid_contact.h"

namespace pbdsurg {

/// A contact of pieces of a group.
struct GroupContact {
  RigidContact contact;         ///< as the first piece has it
  Index first;                  ///< of the group
  Index second{kInvalidIndex};  ///< or kInvalidIndex: what does not move
  Vec3<double> other_arm{};     ///< m, from the centre of the second
};

/// What a contact does at some twists: wrenches on its first piece and on its second, as rows.
struct GroupAnswer {
  static constexpr int kMostSprings = 3;

  double push[12];
  double along[kMostSprings][12];  ///< of springs, for a stiffness of one
  double stiffness[kMostSprings];  ///< kg
  Index spring_count;
};

/// Memory of a balance.
struct GroupSpace {
  static constexpr Index kMostPieces = 8, kMostRows = 6 * kMostPieces;

  double twists[kMostRows];
  double wrenches[kMostRows];  ///< what contacts give beyond the momentum of these
  double way[kMostRows];       ///< Newton's step
  double tried[kMostRows], tried_wrenches[kMostRows];
  double matrix[kMostRows * (kMostRows + 1) / 2];  ///< lower triangle

  /// Once they are balanced.
  [[nodiscard]] PBDSURG_HOST_DEVICE Screw twist_of(Index piece) const {
    const double* const q = twists + 6 * piece;
    return {{q[0], q[1], q[2]}, {q[3], q[4], q[5]}};
  }
};

/// @tparam Workers  see OneWorker: they do all of it together
template <class Workers>
class GroupBalance {
 public:
  /// @param bodies    [count], at most GroupSpace::kMostPieces
  /// @param contacts  [contact_count]
  /// @param answers   [contact_count] for these
  PBDSURG_HOST_DEVICE GroupBalance(const Workers& workers, const RigidBody* bodies, Index count,
                                   const GroupContact* contacts, Index contact_count,
                                   GroupAnswer* answers, GroupSpace& space)
      : workers_(workers),
        bodies_(bodies),
        contacts_(contacts),
        answers_(answers),
        space_(space),
        rows_(6 * count),
        contact_count_(contact_count) {}

  /// Finds the twists. Cost: O(pieces^3) and O(pieces^2 contacts), some six times.
  PBDSURG_DEVICE void run() {
    for_each(rows_, [&](Index row) { space_.twists[row] = 0; });
    workers_.meet();
    double first_slope = 0;
    for (int round = 0; round < kMostRounds; ++round) {
      find_wrenches(space_.twists, space_.wrenches);
      find_way();
      const double slope = along_way(space_.wrenches);
      first_slope = round == 0 ? slope : first_slope;
      if (!(slope > kLeastSlope * first_slope)) {
        break;
      }
      const double share = share_of(slope);
      for_each(rows_, [&](Index row) {
        space_.twists[row] = space_.twists[row] + share * space_.way[row];
      });
      workers_.meet();
    }
  }

 private:
  static constexpr int kMostRounds = 16;  // rarely more than six
  static constexpr int kMostCuts = 10;
  static constexpr double kLeastSlope = 1e-10;  // the square of what may stay out of balance
  static constexpr double kLevel = 0.25;        // of the slope, that counts as none along a way

  template <class Visit>
  PBDSURG_DEVICE void for_each(Index count, const Visit& visit) const {
    for (Index i = workers_.first; i < count; i += workers_.stride) {
      visit(i);
    }
  }

  // Of the way, how much to go: all of it, unless that leads back; else to where it begins to, by
  // false position (Illinois: Dowell and Jarratt 1971).
  [[nodiscard]] PBDSURG_DEVICE double share_of(double slope) {
    double low = 0, low_slope = slope, high = 1, high_slope = 0, share = 1;
    int side = 0;  // of the share before
    for (int cut = 0; cut < kMostCuts; ++cut) {
      for_each(rows_, [&](Index row) {
        space_.tried[row] = space_.twists[row] + share * space_.way[row];
      });
      workers_.meet();
      find_wrenches(space_.tried, space_.tried_wrenches);
      const double now = along_way(space_.tried_wrenches);
      if (now > -kLevel * slope && (cut == 0 || now < kLevel * slope)) {
        break;
      }
      if (now < 0) {
        high = share;
        high_slope = now;
        low_slope *= side < 0 ? 0.5 : 1;
        side = -1;
      } else {
        low = share;
        low_slope = now;
        high_slope *= side > 0 ? 0.5 : 1;
        side = 1;
      }
      share = low + (high - low) * low_slope / (low_slope - high_slope);
    }
    return share;
  }

  [[nodiscard]] PBDSURG_DEVICE double along_way(const double* wrenches) const {
    double sum = 0;
    for (Index row = 0; row < rows_; row += 3) {
      const double* const a = wrenches + row;
      const double* const b = space_.way + row;
      sum += a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    }
    return sum;
  }

  // How a piece moves at a point of it.
  PBDSURG_DEVICE static Vec3<double> move_at(const double* twists, Index piece,
                                             const Vec3<double>& arm) {
    const double* const q = twists + 6 * piece;
    return Vec3<double>{q[0], q[1], q[2]} + cross({q[3], q[4], q[5]}, arm);
  }

  PBDSURG_DEVICE static void put(const Vec3<double>& force, const Vec3<double>& arm, double sign,
                                 double* rows) {
    const Vec3<double> moment = cross(arm, force);
    const double all[] = {force.x, force.y, force.z, moment.x, moment.y, moment.z};
    for (int k = 0; k < 6; ++k) {
      rows[k] = sign * all[k];
    }
  }
  PBDSURG_DEVICE static void put(const GroupContact& contact, const Vec3<double>& force,
                                 double* rows) {
    put(force, contact.contact.arm, 1, rows);
    if (contact.second != kInvalidIndex) {
      put(force, contact.other_arm, -1, rows + 6);
    }
  }

  PBDSURG_DEVICE void find_answer(const double* twists, Index c) {
    const GroupContact& contact = contacts_[c];
    Vec3<double> move = move_at(twists, contact.first, contact.contact.arm);
    if (contact.second != kInvalidIndex) {
      move = move - move_at(twists, contact.second, contact.other_arm);
    }
    const ContactAnswer<double> now = contact.contact.answer(move);
    GroupAnswer& answer = answers_[c];
    put(contact, now.force.push * contact.contact.normal + now.force.drag, answer.push);
    answer.spring_count = 0;
    contact.contact.for_each_spring(now, [&](double stiffness, const Vec3<double>& direction) {
      put(contact, direction, answer.along[answer.spring_count]);
      answer.stiffness[answer.spring_count++] = stiffness;
    });
  }

  // Of the rows of an answer, the one that is a row of the group's; kInvalidIndex: none is.
  [[nodiscard]] PBDSURG_DEVICE Index row_in(Index c, Index row) const {
    const Index piece = row / 6;
    if (contacts_[c].first == piece) {
      return row % 6;
    }
    return contacts_[c].second == piece ? 6 + row % 6 : kInvalidIndex;
  }

  PBDSURG_DEVICE void find_wrenches(const double* twists, double* wrenches) {
    for_each(contact_count_, [&](Index c) { find_answer(twists, c); });
    workers_.meet();
    for_each(rows_, [&](Index row) {
      const double* const q = twists + row / 6 * 6;
      const Screw lack = bodies_[row / 6].lack({{q[0], q[1], q[2]}, {q[3], q[4], q[5]}});
      const double all[] = {lack.linear.x,  lack.linear.y,  lack.linear.z,
                            lack.angular.x, lack.angular.y, lack.angular.z};
      double sum = all[row % 6];
      for (Index c = 0; c < contact_count_; ++c) {
        if (const Index own = row_in(c, row); own != kInvalidIndex) {
          sum += answers_[c].push[own];
        }
      }
      wrenches[row] = sum;
    });
    workers_.meet();
  }

  [[nodiscard]] PBDSURG_DEVICE double& entry(Index row, Index column) const {
    return space_.matrix[row * (row + 1) / 2 + column];
  }

  // From the answers at the twists, and their wrenches.
  PBDSURG_DEVICE void find_way() {
    for_each(rows_ * rows_, [&](Index i) {
      if (i % rows_ <= i / rows_) {
        entry(i / rows_, i % rows_) = sum_of_entry(i / rows_, i % rows_);
      }
    });
    for_each(rows_, [&](Index row) { space_.way[row] = space_.wrenches[row]; });
    workers_.meet();
    // L L^T, which takes the place of the matrix
    for (Index k = 0; k < rows_; ++k) {
      if (workers_.first == 0) {
        entry(k, k) = std::sqrt(entry(k, k));
      }
      workers_.meet();
      for_each(rows_, [&](Index row) {
        if (row > k) {
          entry(row, k) /= entry(k, k);
        }
      });
      workers_.meet();
      for_each((rows_ - k) * (rows_ - k), [&](Index i) {
        const Index row = k + i / (rows_ - k), column = k + i % (rows_ - k);
        if (k < column && column <= row) {
          entry(row, column) -= entry(row, k) * entry(column, k);
        }
      });
      workers_.meet();
    }
    if (workers_.first == 0) {
      solve();
    }
    workers_.meet();
  }

  [[nodiscard]] PBDSURG_DEVICE double sum_of_entry(Index row, Index column) const {
    double sum = row / 6 == column / 6 ? inertia_of(row / 6, row % 6, column % 6) : 0.0;
    for (Index c = 0; c < contact_count_; ++c) {
      const Index first = row_in(c, row), second = row_in(c, column);
      if (first == kInvalidIndex || second == kInvalidIndex) {
        continue;
      }
      const GroupAnswer& answer = answers_[c];
      for (Index s = 0; s < answer.spring_count; ++s) {
        sum += answer.stiffness[s] * answer.along[s][first] * answer.along[s][second];
      }
    }
    return sum;
  }

  [[nodiscard]] PBDSURG_DEVICE double inertia_of(Index piece, Index row, Index column) const {
    const Inertia& i = bodies_[piece].inertia;
    const double turning[] = {i.xx, i.xy, i.yy, i.xz, i.yz, i.zz};
    if (row < 3) {
      return row == column ? bodies_[piece].mass : 0.0;
    }
    return column < 3 ? 0.0 : turning[(row - 3) * (row - 2) / 2 + column - 3];
  }

  PBDSURG_DEVICE void solve() {
    double* const x = space_.way;
    for (Index i = 0; i < rows_; ++i) {
      for (Index j = 0; j < i; ++j) {
        x[i] -= entry(i, j) * x[j];
      }
      x[i] /= entry(i, i);
    }
    for (Index i = rows_; i-- > 0;) {
      for (Index j = i + 1; j < rows_; ++j) {
        x[i] -= entry(j, i) * x[j];
      }
      x[i] /= entry(i, i);
    }
  }

  const Workers& workers_;
  const RigidBody* bodies_;
  const GroupContact* contacts_;
  GroupAnswer* answers_;
  GroupSpace& space_;
  Index rows_, contact_count_;
};

}  // namespace pbdsurg
