// SPDX-License-Identifier: GPL-3.0-or-later
// Bends a mesh: bend in.obj out.obj. The lowest tenth stays, the highest one is turned by 60 degrees.
#include "native/methods/surface/nonlinear/arap.h"

#include <fstream>
#include <iostream>
#include <sstream>

namespace {

/// The vertices and faces of an OBJ file.
sinew::SurfaceMesh read(const char* path)
{
    std::ifstream file(path);
    std::vector<sinew::Vector3> found;
    std::vector<int> counts, corners;
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string word;
        words >> word;
        if (word == "v") {
            sinew::Vector3& point = found.emplace_back();
            words >> point.x() >> point.y() >> point.z();
        } else if (word == "f") {
            counts.push_back(0);
            for (; words >> word; ++counts.back())
                corners.push_back(std::stoi(word) - 1); // up to the first slash
        }
    }
    sinew::Points points(found.size(), 3);
    for (std::size_t i = 0; i < found.size(); ++i)
        points.row(i) = found[i].transpose();
    return {points, counts, corners};
}

void write(const char* path, const sinew::SurfaceMesh& mesh, const sinew::Points& positions)
{
    std::ofstream file(path);
    for (const auto& point : positions.rowwise())
        file << "v " << point << '\n';
    for (int face = 0; face < mesh.face_count(); ++face) {
        file << 'f';
        for (const int corner : mesh.face(face))
            file << ' ' << corner + 1;
        file << '\n';
    }
}

} // namespace

int main(int count, char** words)
try {
    if (count != 3) {
        std::cerr << "usage: bend in.obj out.obj\n";
        return 2;
    }
    const sinew::SurfaceMesh mesh = read(words[1]);
    const auto height = mesh.points().col(2).array();
    const double low = height.minCoeff(), size = height.maxCoeff() - low;
    std::vector<sinew::Handle> handles(2);
    for (int vertex = 0; vertex < mesh.vertex_count(); ++vertex) {
        if (height[vertex] < low + 0.1 * size)
            handles[0].vertices.push_back(vertex);
        if (height[vertex] > low + 0.9 * size)
            handles[1].vertices.push_back(vertex);
    }

    const sinew::Vector3 centre = mesh.points().colwise().mean().transpose();
    const double turn = std::acos(-1.0) / 3.0;
    sinew::SolveRequest request;
    request.poses.assign(2, sinew::Pose::Identity());
    const Eigen::Affine3d bent = Eigen::Translation3d(centre) * Eigen::AngleAxisd(turn, sinew::Vector3::UnitY()) *
                                 Eigen::Translation3d(-centre);
    request.poses[1] = bent.matrix().topRows<3>();

    sinew::Arap arap(mesh);
    arap.set_handles(handles);
    sinew::Points positions;
    arap.solve(request, positions);
    write(words[2], mesh, positions);
} catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
}
