#include <openmm/internal/ContextImpl.h>
#include <openmm/internal/ForceImpl.h>
#include <openmm/reference/ReferenceConstraints.h>
#include <openmm/reference/ReferencePlatform.h>

#include <map>
#include <memory>
#include <string>
#include <utility>

#include "embed/openmm/constrainer_algorithm.hpp"
#include "embed/openmm/tanor_openmm.hpp"

namespace tanor::embed {

namespace {

class ExactConstraintsImpl : public OpenMM::ForceImpl {
 public:
  explicit ExactConstraintsImpl(const ExactConstraints& owner) : owner_(owner) {}

  void initialize(OpenMM::ContextImpl& context) override {
    // The CPU platform is derived from Reference and keeps its data.
    if (dynamic_cast<OpenMM::ReferencePlatform*>(&context.getPlatform()) == nullptr) {
      throw OpenMM::OpenMMException("ExactConstraints: the platform " + context.getPlatform().getName() +
                                    " keeps its constraints to itself; give the Context the platform CPU or Reference");
    }
    auto* const data = static_cast<OpenMM::ReferencePlatform::PlatformData*>(context.getPlatformData());
    OpenMM::ReferenceConstraints& constraints = *data->constraints;
    if (dynamic_cast<ConstrainerAlgorithm*>(constraints.ccma) != nullptr)
      throw OpenMM::OpenMMException("ExactConstraints: the System contains more than one");
    auto algorithm = std::make_unique<ConstrainerAlgorithm>(context.getSystem(), owner_.added(), owner_.threads());
    delete std::exchange(constraints.settle, nullptr);
    delete std::exchange(constraints.ccma, algorithm.release());
  }

  const OpenMM::Force& getOwner() const override { return owner_; }
  void updateContextState(OpenMM::ContextImpl&, bool&) override {}
  double calcForcesAndEnergy(OpenMM::ContextImpl&, bool, bool, int) override { return 0.0; }
  std::map<std::string, double> getDefaultParameters() override { return {}; }
  std::vector<std::string> getKernelNames() override { return {}; }
  /// Constrained particles belong to one molecule, so barostats move them as a whole.
  std::vector<std::pair<int, int>> getBondedParticles() const override {
    std::vector<std::pair<int, int>> bonds;
    for (const DistanceConstraint& one : owner_.added()) bonds.emplace_back(one.particle1, one.particle2);
    return bonds;
  }

 private:
  const ExactConstraints& owner_;
};

}  // namespace

int ExactConstraints::addConstraint(int particle1, int particle2, double distance) {
  added_.push_back({particle1, particle2, distance});
  return getNumConstraints() - 1;
}

void ExactConstraints::getConstraintParameters(int index, int& particle1, int& particle2, double& distance) const {
  if (index < 0 || index >= getNumConstraints())
    throw OpenMM::OpenMMException("ExactConstraints: there is no constraint " + std::to_string(index));
  const DistanceConstraint& one = added_[static_cast<std::size_t>(index)];
  particle1 = one.particle1, particle2 = one.particle2, distance = one.distance;
}

OpenMM::ForceImpl* ExactConstraints::createImpl() const {
  return new ExactConstraintsImpl(*this);
}

}  // namespace tanor::embed

void tanor_openmm_add_exact_constraints(void* system) {
  static_cast<OpenMM::System*>(system)->addForce(new tanor::embed::ExactConstraints);
}
