#pragma once

#include <string_view>

namespace tanor::scene {

/// A chemical element.
struct Element {
  std::string_view symbol;  ///< "H", "He"
  double mass;              ///< u: standard atomic weights of IUPAC (2016), or of the longest lived isotope
  double covalent_radius;   ///< angstrom: Cordero et al., Dalton Trans. (2008) 2832
};

/// Finds an element by its symbol, in upper or lower case; null if there is none.
const Element* find_element(std::string_view symbol);

/// Guesses an element from the name of an atom, as molecular programs write it ("CA", "HW1", "1HB", "CL16"), and that
/// of its residue: calcium is "CA" in a residue of that name and "Ca" anywhere. Returns null if the name does not tell,
/// as for virtual sites and grains of several atoms.
const Element* guess_element(std::string_view atom, std::string_view residue);

}  // namespace tanor::scene
