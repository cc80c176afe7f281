// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/remeshing/manifold.h"
#include "native/mesh/remeshing/remeshed.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>

#include <map>

namespace sinew {

// Included only by sources that are compiled with CGAL.
using CgalKernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using CgalMesh = CGAL::Surface_mesh<CgalKernel::Point_3>;

inline CgalMesh::Property_map<CgalMesh::Edge_index, bool> lines_of(CgalMesh& mesh)
{
    return mesh.add_property_map<CgalMesh::Edge_index, bool>("e:line", false).first;
}

inline CgalMesh::Property_map<CgalMesh::Vertex_index, bool> stays_of(CgalMesh& mesh)
{
    return mesh.add_property_map<CgalMesh::Vertex_index, bool>("v:stays", false).first;
}

/// The mesh for CGAL, with its lines and the vertices that stay as properties.
inline CgalMesh cgal_mesh(const Manifold& from)
{
    CgalMesh mesh;
    const auto line = lines_of(mesh);
    const auto stays = stays_of(mesh);
    const auto add = [&](int v) {
        const Vector3& p = from.points[v];
        const auto made = mesh.add_vertex({p.x(), p.y(), p.z()});
        stays[made] = from.stays[v] != 0;
        return made;
    };
    for (int v = 0; v < static_cast<int>(from.points.size()); ++v)
        add(v);
    using Vertex = CgalMesh::Vertex_index;
    for (const auto& [a, b, c] : from.triangles)
        if (mesh.add_face(Vertex(a), Vertex(b), Vertex(c)) == CgalMesh::null_face())
            // The cuts around it closed up again: it gets vertices of its own.
            mesh.add_face(add(a), add(b), add(c));
    for (const Manifold::Line& along : from.lines)
        if (const auto h = mesh.halfedge(Vertex(along.edge[0]), Vertex(along.edge[1]));
            h != CgalMesh::null_halfedge())
            line[mesh.edge(h)] = true;
    for (const auto v : mesh.vertices())
        if (mesh.is_isolated(v))
            mesh.remove_vertex(v);
    return mesh;
}

/// Points, triangles and lines of a mesh, with new numbers.
inline void read_back(CgalMesh& mesh, Remeshed& into)
{
    const auto line = lines_of(mesh);
    std::vector<int> numbers(mesh.num_vertices(), -1);
    for (const auto f : mesh.faces()) {
        Triangle triangle;
        int k = 0;
        for (const auto v : mesh.vertices_around_face(mesh.halfedge(f))) {
            int& number = numbers[v];
            if (number < 0) {
                number = static_cast<int>(into.points.size());
                into.points.emplace_back(mesh.point(v).x(), mesh.point(v).y(), mesh.point(v).z());
            }
            triangle[k++] = number;
        }
        into.triangles.push_back(triangle);
    }
    for (const auto e : mesh.edges())
        if (line[e] || mesh.is_border(e))
            into.lines.push_back(
                {numbers[mesh.source(mesh.halfedge(e))], numbers[mesh.target(mesh.halfedge(e))]});
}

} // namespace sinew
