#include "friction/contact_coupling.hpp"

#include <algorithm>

namespace tanor::detail {

ContactCoupling::ContactCoupling(const Workspace& work, const FrictionLaws& laws)
    : model_(work.model()),
      tangents_(work.constraints.tangents()),
      laws_(laws),
      incidences_of_contact_(work.constraints.tangents().size()) {
  std::vector<std::vector<Index>> contacts_of_point(model_.num_points());
  for (std::size_t c = 0; c < tangents_.size(); ++c)
    contacts_of_point[static_cast<std::size_t>(tangents_[c].point)].push_back(static_cast<Index>(c));
  struct RowTouch {
    Index row, part;
    Touch touch;
  };
  std::vector<RowTouch> all;
  for (std::size_t k = 0; k < model_.incidences.size(); ++k) {
    const Incidence& i = model_.incidences[k];
    const auto point = static_cast<std::size_t>(i.point);
    for (const Index contact : contacts_of_point[point]) {
      const auto c = static_cast<std::size_t>(contact);
      if (!touches(i, c)) continue;
      incidences_of_contact_[c].push_back(k);
      for (std::size_t part = laws_.first_part(c); part < laws_.end_part(c); ++part)
        all.push_back({i.row, static_cast<Index>(part), {i.block, i.sign * model_.inverse_mass[point]}});
    }
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.row < b.row; });
  for (const auto& [row, part, touch] : all) {
    if (touched_rows_.empty() || touched_rows_.back() != row) {
      touched_rows_.push_back(row);
      touch_start_.push_back(static_cast<Index>(touches_.size()));
    }
    touches_.push_back(touch);
    shares_.push_back({part, 0.0});
  }
  touch_start_.push_back(static_cast<Index>(touches_.size()));
}

bool ContactCoupling::touches(const Incidence& i, std::size_t contact) const {
  const Tangents::Place& place = tangents_[contact];
  const auto guides_end = place.guide_row.begin() + place.num_guides;
  const bool is_guide = std::find(place.guide_row.begin(), guides_end, i.row) != guides_end;
  return laws_.has_three_parts(contact) || !is_guide;
}

void ContactCoupling::set_place(const double* blocks) {
  blocks_ = blocks;
  for (std::size_t k = 0; k < touches_.size(); ++k) {
    const Vec3 e = laws_.part_direction(static_cast<std::size_t>(shares_[k].part));
    shares_[k].size = touches_[k].weight * dot(load(blocks, touches_[k].block), e);
  }
}

/// Returns (K'M^-1 tau)_a = sum of (g_a'e_p/m) x_p.
double ContactCoupling::row(std::size_t touched, const double* x) const {
  double sum = 0.0;
  for (Index t = touch_start_[touched]; t < touch_start_[touched + 1]; ++t) {
    const Share& share = shares_[static_cast<std::size_t>(t)];
    sum += share.size * x[share.part];
  }
  return sum;
}

void ContactCoupling::gather(const double* b, double* touched) const {
  for (std::size_t k = 0; k < touched_rows_.size(); ++k) touched[k] = b[touched_rows_[k]];
}

void ContactCoupling::write(const double* base, const double* x, double* rows) const {
  for (std::size_t k = 0; k < touched_rows_.size(); ++k)
    rows[touched_rows_[k]] = (base != nullptr ? base[k] : 0.0) + row(k, x);
}

void ContactCoupling::add_to_rows(double sign, const double* x, double* b) const {
  for (std::size_t k = 0; k < touched_rows_.size(); ++k) b[touched_rows_[k]] += sign * row(k, x);
}

void ContactCoupling::add_force(std::size_t contact, Vec3 force, double* b) const {
  for (const std::size_t k : incidences_of_contact_[contact]) {
    const Incidence& i = model_.incidences[k];
    const double weight = i.sign * model_.inverse_mass[static_cast<std::size_t>(i.point)];
    b[i.row] += weight * dot(load(blocks_, i.block), force);
  }
}

void ContactCoupling::add_to_points(double factor, const double* tau, double* w) const {
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    const auto point = static_cast<std::size_t>(tangents_[c].point);
    add_to(w, point, factor * model_.inverse_mass[point] * load(tau, c));
  }
}

void ContactCoupling::add_change(double factor, const double* tau, const double* before, double* w) const {
  for (std::size_t c = 0; c < tangents_.size(); ++c) {
    const auto point = static_cast<std::size_t>(tangents_[c].point);
    add_to(w, point, factor * model_.inverse_mass[point] * (load(tau, c) - load(before, c)));
  }
}

}  // namespace tanor::detail
