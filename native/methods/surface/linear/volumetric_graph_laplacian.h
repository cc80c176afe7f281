// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/hidden.h"
#include "native/core/options.h"
#include "native/methods/surface/method.h"
#include "native/operators/laplacian.h"

#include <array>
#include <string>
#include <vector>

namespace sinew {

struct VolumetricGraphLaplacianOptions
{
    double volume = 1.0;
    Discretization laplacian = Discretization::cotan_voronoi;

    static constexpr auto table()
    {
        using O = VolumetricGraphLaplacianOptions;
        return std::tuple{
            option("volume", &O::volume, Rebind::update, at_least(0),
                   "alpha, how much the graph counts beside the surface; 0 leaves the surface alone"),
            option("laplacian", &O::laplacian, Rebind::anew,
                   "'uniform', 'cotan', 'cotan_voronoi' or 'robust' (section 3.2), of the surface")};
    }
};

/// Laplacian editing of a surface together with a graph of points inside, which holds its sides apart.
///
/// K. Zhou, J. Huang, J. Snyder, X. Liu, H. Bao, B. Guo, H.-Y. Shum. "Large Mesh Deformation Using the
/// Volumetric Graph Laplacian." SIGGRAPH 2005. Tutorial, section 4.5.2.
///
/// The nodes of the graph are the vertices and the points inside them (volume/volume_graph.h). A node with
/// the neighbours j has the differential coordinate
///
///     (D p)_i = p_i - sum_j w_ij p_j,    w_ij proportional to 1 / |p_i - p_j|, with the sum 1,
///
/// and with base points y (the incoming shape, or the rest shape), L and M of operators/laplacian.h and the
/// mean m of the masses of the part, the nodes x minimise
///
///     1/2 sum_i m_i |(M^-1 L x)_i - T_i (M^-1 L y)_i|^2  +  alpha / 2m sum_k |(D x)_k - T_k (D y)_k|^2,
///
/// the first sum over the vertices, the second over all nodes that have an edge, held ones included. T_i
/// blends the linear maps of the handles (see handles/map_blend.h) by fields that are harmonic over surface
/// and graph together, where an edge of the graph conducts as the mean edge of the part over its length. Soft
/// handles add s_i |x_i - t_i|^2 / 2 with s_i = w / (1 - w) A_ii, A the matrix of the system.
///
/// In an incoming shape, each point of the graph rides on three vertices (attachments/loose_vertices.h).
///
/// Departs from the paper: the inner layer has fewer points than the surface; cubes in place of a
/// body-centred lattice, with wider cells in place of edge collapses; weights by lengths, not by a quadratic
/// program; the surface has weights of cotangents and areas unless the options say otherwise; transformations
/// fade by harmonic fields, of any number of handles. A part without an inside, such as an open sheet, is
/// edited as by LaplacianEditing with `from_handles`.
///
///   call           repeat it when ...            cost
///   constructor    rest shape or faces changed   nothing
///   set_handles()  another set of handles        two factorisations, of A and of the graph's Laplacian, and
///                                                a solve of as many columns as handles less one; the first
///                                                one also makes the graph, 30 us per vertex
///   solve()        the handles moved             one solve for x, y and z
///
/// Affine motions of all handles are reproduced. A handle that only moves turns nothing.
class VolumetricGraphLaplacian final : public SurfaceMethodWith<VolumetricGraphLaplacianOptions>
{
public:
    /// \throw InvalidOption  `volume` is negative or not finite.
    explicit VolumetricGraphLaplacian(const SurfaceMesh& rest,
                                      const VolumetricGraphLaplacianOptions& options = {});

    /// (g, 3) the points inside, at rest; none before the first bind.
    Points inner_points() const;
    /// (e) the edges a < b of the graph; node n + k is inner point k.
    std::vector<std::array<int, 2>> graph_edges() const;

protected:
    void bind(const Regions& regions, BindReport& report, const Progress& progress) override;
    SolveReport deform(const SolveRequest& request, const Targets& targets, Points& positions) const override;
    void swap_binding(SurfaceMethod& other) override;

private:
    struct Impl;
    Hidden<Impl> impl_;
};

} // namespace sinew
