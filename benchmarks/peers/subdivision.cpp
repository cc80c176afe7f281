// SPDX-License-Identifier: GPL-3.0-or-later
// OpenSubdiv's own evaluator of stencils on the CPU, as its tutorials use it: Catmull-Clark, with three
// floats per point.
#include <opensubdiv/far/stencilTable.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>
#include <opensubdiv/osd/cpuEvaluator.h>
#include <opensubdiv/osd/cpuVertexBuffer.h>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <memory>
#include <stdexcept>

namespace py = pybind11;
namespace Far = OpenSubdiv::Far;
namespace Osd = OpenSubdiv::Osd;
namespace Sdc = OpenSubdiv::Sdc;

namespace {

using Floats = py::array_t<float, py::array::c_style>;

class Evaluator
{
public:
    Evaluator(int vertices, const py::array_t<int, py::array::c_style>& quads, int level)
        : vertices_(vertices)
    {
        const std::vector<int> counts(quads.shape(0), 4);
        Far::TopologyDescriptor topology;
        topology.numVertices = vertices;
        topology.numFaces = static_cast<int>(counts.size());
        topology.numVertsPerFace = counts.data();
        topology.vertIndicesPerFace = quads.data();
        using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
        Sdc::Options options;
        options.SetVtxBoundaryInterpolation(Sdc::Options::VTX_BOUNDARY_EDGE_ONLY);
        const std::unique_ptr<Far::TopologyRefiner> refiner(
            Factory::Create(topology, Factory::Options(Sdc::SCHEME_CATMARK, options)));
        refiner->RefineUniform(Far::TopologyRefiner::UniformOptions(level));
        Far::StencilTableFactory::Options wanted;
        wanted.generateIntermediateLevels = false;
        wanted.generateOffsets = true;
        table_.reset(Far::StencilTableFactory::Create(*refiner, wanted));
        from_.reset(Osd::CpuVertexBuffer::Create(3, vertices));
        to_.reset(Osd::CpuVertexBuffer::Create(3, table_->GetNumStencils()));
    }

    void refine(const Floats& points)
    {
        if (points.size() != 3 * vertices_)
            throw std::invalid_argument("points");
        from_->UpdateData(points.data(), 0, vertices_);
        const Osd::BufferDescriptor three(0, 3, 3);
        Osd::CpuEvaluator::EvalStencils(from_.get(), three, to_.get(), three, table_.get());
    }

    Floats result() const
    {
        return Floats({py::ssize_t{table_->GetNumStencils()}, py::ssize_t{3}}, to_->BindCpuBuffer());
    }

private:
    int vertices_;
    std::unique_ptr<const Far::StencilTable> table_;
    std::unique_ptr<Osd::CpuVertexBuffer> from_, to_;
};

} // namespace

void bind_subdivision(py::module_& m)
{
    using namespace py::literals;
    py::class_<Evaluator>(m, "StencilEvaluator")
        .def(py::init<int, py::array_t<int, py::array::c_style>, int>(), "vertices"_a, "quads"_a, "level"_a)
        .def("refine", &Evaluator::refine, "points"_a)
        .def_property_readonly("result", &Evaluator::result);
}
