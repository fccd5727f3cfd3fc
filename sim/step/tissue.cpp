#include "sim/step/tissue.h"

#include <fmt/format.h>

namespace kerf {

Expected<TissueTable> tissueTable(const MaterialTable& materials, Material fallback) {
  TissueTable out;
  for (const MaterialProperties& row : materials.rows()) {
    const int number = static_cast<int>(row.material);
    if (number < 0 || number > 255) continue;
    const double energy = 1000 * row.specific_cutting_energy.value;  // J/mm^3 to N mm / mm^3
    if (!(row.contact_stiffness.value > 0) || !(energy > 0))
      return fail({.code = Error::Code::kBadValue,
                   .place = "material " + row.id,
                   .found = fmt::format("contact_stiffness {} N/mm3, specific_cutting_energy {} J/mm3",
                                        row.contact_stiffness.value, row.specific_cutting_energy.value),
                   .expected = "both above 0",
                   .hint = "correct materials.toml"});
    out[static_cast<std::size_t>(number)] = {static_cast<float>(row.contact_stiffness.value),
                                             static_cast<float>(row.friction.value), static_cast<float>(1 / energy),
                                             true};
  }

  const Tissue& rest = out[static_cast<std::size_t>(fallback) & 255u];
  if (!rest.is_in_table)
    return fail({.code = Error::Code::kNotFound,
                 .place = fmt::format("material {}", static_cast<int>(fallback)),
                 .found = "not in the table of materials",
                 .expected = "one of " + materials.ids(),
                 .hint = "correct materials.toml"});
  for (Tissue& tissue : out)
    if (!tissue.is_in_table) tissue = {rest.stiffness, rest.friction, rest.inverse_energy, false};
  return out;
}

}  // namespace kerf
