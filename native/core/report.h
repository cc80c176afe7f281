// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

namespace sinew {

/// How much rebind() took over from the earlier object.
enum class Reuse {
    anew,    ///< nothing
    updated, ///< a part; the rest was computed again
    kept     ///< everything: nothing was computed
};

/// The name of a setting, and whether the setting differs between two objects.
struct Difference
{
    const char* name;
    bool differs;
};
/// `names`, followed by the names of the settings that differ.
std::vector<std::string> names_of(std::initializer_list<Difference> differences,
                                  std::vector<std::string> names = {});
/// "bending, handles".
std::string joined(const std::vector<std::string>& names);

/// How many things there are, with the word for one and for several of them.
struct Count
{
    std::size_t number;
    const char *one, *several;
};
/// "1 open edge, 3 points outside": the counts that are not zero; "clean" where all are zero.
std::string summary_of(std::initializer_list<Count> counts);

/// A part without a handle that rides on another part.
struct Ride
{
    int part;         ///< parts are numbered by their lowest vertices
    int first_vertex; ///< of the part
    int vertex_count;
    int host;        ///< the part it rides on, which may ride itself
    int frame_count; ///< 1 where it moves rigidly
};

/// What set_handles() or rebind() did.
struct BindReport
{
    Reuse reuse = Reuse::anew;
    std::string changed; ///< what differs from the earlier object: "bending, handles"; empty for nothing
    int handle_count = 0;
    int constrained_vertices = 0;   ///< vertices that a handle holds exactly
    int soft_vertices = 0;          ///< vertices that a handle pulls softly
    int free_parts = 0;             ///< connected parts without any constraint that stay at rest
    std::vector<int> free_vertices; ///< the vertices of those parts
    std::vector<Ride> rides;        ///< connected parts without any constraint that follow others
    std::vector<int> riding_vertices; ///< the vertices of those parts
    /// Details that a method around another one stores as vectors, because its coding has none for them.
    int detail_vectors = 0;
    int irregular_parts = 0; ///< parts with a handle that a method for subdivided meshes could not coarsen
    std::vector<int> irregular_vertices; ///< the vertices of those parts
    /// Vertices at edges where a sheet is thinner than the mesh can show, so that it bends less than asked
    /// for.
    std::vector<int> thin_vertices;
    std::vector<std::string> remarks; ///< what the method cannot carry, and what is used instead
    int degenerate_faces = 0; ///< faces with a triangle of (nearly) no area, whose area was raised
    int factorizations = 0; ///< numeric factorisations so far, with those of earlier objects
    int analyses = 0; ///< symbolic factorisations so far, likewise
    double refactored = 0.0; ///< share of the last numeric factorisation that had to be computed
    std::int64_t factor_bytes = 0; ///< memory of the factors, without the workspace of solves
    double seconds = 0.0; ///< wall clock time of the call
};

/// What solve() reached.
struct SolveReport
{
    int iterations = 0; ///< accepted steps; 1 for a linear method
    int rejected = 0; ///< trial steps that did not lower the energy
    double energy = 0.0; ///< of the returned shape: E of the method's class, soft handles included
    double residual = 0.0; ///< of a linear method |A d - b| / |b|; else what was compared with the tolerance
    bool converged = false; ///< whether the tolerance was met before the iterations were used up
    /// Vertices between handles that are turned against each other by half a turn, where a rule chose the way
    /// to turn.
    int half_turns = 0;
    int fallbacks = 0; ///< how often a quick iteration stalled, so that a slow one took over
    int inverted_faces = 0; ///< faces that the shape turns over against the rigid bodies that carry them
};

} // namespace sinew
