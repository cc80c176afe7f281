// SPDX-License-Identifier: GPL-3.0-or-later
// Bends a mesh: bend in.obj out.obj. The lowest tenth stays, the highest turns by 60 degrees.
#include "native/methods/surface/nonlinear/arap.h"

#include <Eigen/Geometry>

#include <charconv>
#include <cmath>
#include <fstream>
#include <iostream>
#include <sstream>

namespace {

/// The vertices and faces of an OBJ file.
sinew::SurfaceMesh read(const std::string& path)
{
    std::ifstream file(path);
    if (!file)
        throw std::runtime_error(path + ": cannot be read");
    std::vector<sinew::Vector3> found;
    std::vector<int> counts, corners;
    for (std::string line, word; std::getline(file, line);) {
        std::istringstream words(line);
        words >> word;
        if (word == "v") {
            sinew::Vector3& point = found.emplace_back();
            if (!(words >> point.x() >> point.y() >> point.z()))
                throw std::runtime_error(path + ": three numbers are missing in " + line);
        } else if (word == "f") {
            counts.push_back(0);
            for (; words >> word; ++counts.back()) {
                int corner = 0; // the number before the first slash; if there is none, that of no vertex
                std::from_chars(word.data(), word.data() + word.size(), corner);
                corners.push_back(corner - 1);
            }
        }
    }
    sinew::Points points(found.size(), 3);
    for (std::size_t i = 0; i < found.size(); ++i)
        points.row(i) = found[i].transpose();
    return {points, counts, corners}; // or throws InvalidMesh
}

void write(const std::string& path, const sinew::Points& positions, const sinew::SurfaceMesh& mesh)
{
    std::ofstream file(path);
    file.precision(17);
    for (const auto& point : positions.rowwise())
        file << "v " << point.x() << ' ' << point.y() << ' ' << point.z() << '\n';
    for (int face = 0; face < mesh.face_count(); ++face) {
        file << 'f';
        for (const int corner : mesh.face(face))
            file << ' ' << corner + 1;
        file << '\n';
    }
    if (!file.flush())
        throw std::runtime_error(path + ": cannot be written");
}

void bend(const std::string& source, const std::string& target)
{
    const sinew::SurfaceMesh mesh = read(source);
    const auto height = mesh.points().col(2).array();
    const double low = height.minCoeff(), size = height.maxCoeff() - low;
    std::vector<sinew::Handle> handles(2);
    for (int vertex = 0; vertex < mesh.vertex_count(); ++vertex) {
        if (height[vertex] < low + 0.1 * size)
            handles[0].vertices.push_back(vertex);
        else if (height[vertex] > low + 0.9 * size)
            handles[1].vertices.push_back(vertex);
    }

    const Eigen::Translation3d centre(mesh.points().colwise().mean().transpose());
    const Eigen::AngleAxisd turn(std::acos(-1.0) / 3.0, sinew::Vector3::UnitY());
    sinew::SolveRequest request;
    request.poses.assign(2, sinew::Pose::Identity());
    request.poses[1] = (centre * turn * centre.inverse()).matrix().topRows<3>();

    sinew::Arap arap(mesh);
    arap.set_handles(handles); // factorises, once for all poses
    sinew::Points positions;
    arap.solve(request, positions);
    write(target, positions, mesh);
}

} // namespace

int main(int count, char** words)
try {
    if (count != 3)
        throw std::runtime_error("usage: bend in.obj out.obj");
    bend(words[1], words[2]);
} catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
}
