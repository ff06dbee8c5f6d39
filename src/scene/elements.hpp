#pragma once

#include <string_view>

namespace tanor::scene {

/// A chemical element.
struct Element {
  std::string_view symbol;  ///< "H", "He"
  double mass;  ///< u: standard atomic weights of IUPAC (2016), of the longest lived isotope where none is given
  double covalent_radius;  ///< angstrom: Cordero et al., Dalton Trans. (2008) 2832
};

/// By its symbol, in upper or lower case; null where there is none.
const Element* find_element(std::string_view symbol);

/// From the name of an atom, as molecular programs name them ("CA", "HW1", "1HB", "CL16"), and that of its residue:
/// calcium is "CA" in a residue of that name and "Ca" anywhere. Null where a name does not tell, as those of virtual
/// sites and of grains of several atoms.
const Element* guess_element(std::string_view atom, std::string_view residue);

}  // namespace tanor::scene
