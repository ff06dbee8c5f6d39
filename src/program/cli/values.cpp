#include "cli/values.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

namespace tanor::cli {

Value list(std::vector<std::string>* target) {
  return {Word::Text, [target](const std::string& given) -> std::string {
            for (std::size_t begin = 0; begin <= given.size();) {
              const std::size_t end = std::min(given.find(',', begin), given.size());
              if (end == begin) return "must be names between commas, not '" + given + "'";
              target->push_back(given.substr(begin, end - begin));
              begin = end + 1;
            }
            return {};
          }};
}

Value offer(std::vector<std::string> offers, Value value, Word word) {
  value.word = word;
  value.offers = std::move(offers);
  return value;
}

Value size_of_picture(picture::Style* style) {
  return {Word::Text, [style](const std::string& given) -> std::string {
            constexpr int least = 64, most = 10'000;
            const std::size_t middle = std::min(given.find('x'), given.size());
            const auto width = read_number<int>(given.substr(0, middle));
            const auto height = read_number<int>(given.substr(std::min(middle + 1, given.size())));
            if (!width || !height || std::min(*width, *height) < least || std::max(*width, *height) > most)
              return "must be WIDTHxHEIGHT in pixels, 64 to 10000 each, such as 1600x1000, not '" + given + "'";
            style->width = *width;
            style->height = *height;
            return {};
          }};
}

Value view_of_picture(picture::Style* style) {
  return offer(
      {"auto", "x", "-x", "y", "-y", "z", "-z"},
      {Word::Text, [style](const std::string& given) -> std::string {
         style->from.reset();
         style->angles.reset();
         if (given == "auto") return {};
         const bool is_negative = given.starts_with('-');
         const std::string axis = given.substr(is_negative ? 1 : 0);
         if (axis == "x" || axis == "y" || axis == "z") {
           style->from.emplace().fill(0.0);
           (*style->from)[static_cast<std::size_t>(axis[0] - 'x')] = is_negative ? -1.0 : 1.0;
           return {};
         }
         const std::size_t middle = std::min(given.find(','), given.size());
         const auto around = read_number<double>(given.substr(0, middle));
         const auto above = read_number<double>(given.substr(std::min(middle + 1, given.size())));
         if (!around || !above || !(std::abs(*around) <= 360.0) || !(std::abs(*above) <= 90.0))
           return "must be auto, x, -x, y, -y, z, -z (from where one looks) or AROUND,ABOVE in degrees, such as "
                  "30,20, not '" +
                  given + "'";
         style->angles = {*around, *above};
         return {};
       }});
}

Value projection_of_picture(picture::Style* style) {
  return offer({"perspective", "orthographic"}, {Word::Text, [style](const std::string& given) -> std::string {
                                                   if (given != "perspective" && given != "orthographic")
                                                     return "must be perspective or orthographic, not '" + given + "'";
                                                   style->projection = given == "perspective"
                                                                           ? picture::Projection::Perspective
                                                                           : picture::Projection::Orthographic;
                                                   return {};
                                                 }});
}

Value parts_of_picture(picture::Style* style) {
  return offer(
      {"points", "rods", "reactions", "normal", "tangent", "guides", "legend"},
      {Word::Text,
       [style](const std::string& given) -> std::string {
         const std::array<std::pair<const char*, std::vector<bool*>>, 7> parts{
             {{"points", {&style->shows_points}},
              {"rods", {&style->shows_rods}},
              {"reactions", {&style->shows_normal, &style->shows_tangent}},
              {"normal", {&style->shows_normal}},
              {"tangent", {&style->shows_tangent}},
              {"guides", {&style->shows_guides}},
              {"legend", {&style->shows_legend}}}};
         for (const auto& [name, switches] : parts)
           for (bool* each : switches) *each = false;
         std::vector<std::string> words;
         if (std::string wrong = list(&words).take(given); !wrong.empty()) return wrong;
         for (const std::string& word : words) {
           const auto found = std::ranges::find(parts, word, [](const auto& part) { return part.first; });
           if (found == parts.end())
             return "must be names of points, rods, reactions, normal, tangent, guides, legend between commas, not '" +
                    word + "'";
           for (bool* each : found->second) *each = true;
         }
         return {};
       }},
      Word::Choices);
}

}  // namespace tanor::cli
