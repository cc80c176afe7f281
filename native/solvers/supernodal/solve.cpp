// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/supernodal/solve.h"

#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/solvers/supernodal/kernels.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

namespace sinew {

namespace {

constexpr int block_width = LaneSupernode<double>::triangle_width;
constexpr int most_subtrees = 16;
constexpr double least_parallel = 1.5e5; ///< entries of the factor; for fewer, one thread is faster

} // namespace

template <class T>
struct SupernodalSolve<T>::Impl
{
    /// Supernodes [begin, end) with everything below them: columns [first_column, last_column).
    struct Subtree
    {
        int begin, end;
        int first_column, last_column;
    };

    /// Kept for later solves; each of several solves at once has its own.
    struct Workspace
    {
        std::vector<T> points;            ///< (n) points of four lanes in the order of elimination
        std::vector<std::vector<T>> sums; ///< one per subtree: its contributions to the unknowns on top
        std::vector<std::vector<T>> spaces; ///< for the kernels: one per subtree, and one for the top
    };

    explicit Impl(const BasicSupernodalFactor<T>& factor)
        : f(factor), kernels(widest_kernels<LaneKernels<T>>())
    {
        invert_diagonal_blocks({});
        choose_subtrees();
    }

    int columns(int s) const { return f.columns(s); }
    int height(int s) const { return f.height(s); }
    T* block(int s) const { return f.block(s); }

    /// For the chosen supernodes, or for all if `chosen` is empty.
    void invert_diagonal_blocks(const std::vector<char>& chosen)
    {
        reciprocals.resize(f.size);
        parallel_chunks(f.supernodes, 256, [&](int begin, int end) {
            for (int s = begin; s < end; ++s) {
                if (!chosen.empty() && !chosen[s])
                    continue;
                const int stride = height(s);
                for (int c = 0; c < columns(s); c += block_width)
                    invert(block(s) + c * (stride + 1), stride, std::min(block_width, columns(s) - c),
                           reciprocals.data() + f.first[s] + c);
            }
        });
    }

    /// Inverts a lower triangle L. The diagonal of the inverse goes to `diagonal`, its strict part transposed
    /// above the diagonal of L.
    static void invert(T* L, int stride, int width, T* diagonal)
    {
        for (int i = 0; i < width; ++i) {
            diagonal[i] = 1.0 / L[i * (stride + 1)];
            for (int j = 0; j < i; ++j) {
                T sum = L[i + j * stride] * diagonal[j];
                for (int k = j + 1; k < i; ++k)
                    sum += L[i + k * stride] * L[j + k * stride];
                L[j + i * stride] = -diagonal[i] * sum;
            }
        }
    }

    /// Cuts the tree into subtrees of similar weight, which run in parallel, and supernodes on top of them.
    void choose_subtrees()
    {
        std::vector<double> entries(f.supernodes);
        for (int s = 0; s < f.supernodes; ++s)
            entries[s] = static_cast<double>(columns(s)) * height(s);
        on_top.assign(f.supernodes, false);
        if (std::accumulate(entries.begin(), entries.end(), 0.0) < least_parallel)
            return;
        SupernodalSplit cut = split(SupernodalTree(f), std::move(entries), most_subtrees);
        for (const auto [begin, end] : cut.parts)
            subtrees.push_back({begin, end, f.first[begin], f.first[end]});
        on_top = std::move(cut.on_top);
        top_position.assign(f.size, -1);
        for (int s = 0; s < f.supernodes; ++s)
            if (on_top[s])
                for (int c = f.first[s]; c < f.first[s + 1]; ++c)
                    top_position[c] = top_count++;
    }

    LaneSupernode<T> supernode(int s) const
    {
        return {block(s), reciprocals.data() + f.first[s], f.rows_of(s) + columns(s), columns(s), height(s)};
    }

    /// The contributions to rows from `inside` on go to `sums`.
    void forward(int s, int lanes, T* points, int inside, T* sums, T* space) const
    {
        kernels.forward(supernode(s), lanes, points + lane_count * static_cast<std::size_t>(f.first[s]),
                        points, inside, sums, top_position.data(), space);
    }

    void backward(int s, int lanes, T* points, T* space) const
    {
        kernels.backward(supernode(s), lanes, points + lane_count * static_cast<std::size_t>(f.first[s]),
                         points, space);
    }

    static void add(T* to, const T* from)
    {
        for (int k = 0; k < lane_count; ++k)
            to[k] += from[k];
    }

    void sweep(T* points, int lanes, Workspace& work) const
    {
        T* const space = work.spaces.back().data();
        const int tasks = static_cast<int>(subtrees.size());
        if (tasks == 0) {
            for (int s = 0; s < f.supernodes; ++s)
                forward(s, lanes, points, f.size, nullptr, space);
            for (int s = f.supernodes - 1; s >= 0; --s)
                backward(s, lanes, points, space);
            return;
        }
        parallel_tasks(tasks, [&](int t) {
            std::fill(work.sums[t].begin(), work.sums[t].end(), T(0));
            for (int s = subtrees[t].begin; s < subtrees[t].end; ++s)
                forward(s, lanes, points, subtrees[t].last_column, work.sums[t].data(),
                        work.spaces[t].data());
        });
        for (int s = 0; s < f.supernodes; ++s)
            if (on_top[s])
                for (int c = f.first[s]; c < f.first[s + 1]; ++c)
                    for (int t = 0; t < tasks; ++t)
                        add(points + lane_count * static_cast<std::size_t>(c),
                            work.sums[t].data() + lane_count * static_cast<std::size_t>(top_position[c]));
        for (int s = 0; s < f.supernodes; ++s)
            if (on_top[s])
                forward(s, lanes, points, f.size, nullptr, space);
        for (int s = f.supernodes - 1; s >= 0; --s)
            if (on_top[s])
                backward(s, lanes, points, space);
        parallel_tasks(tasks, [&](int t) {
            for (int s = subtrees[t].end - 1; s >= subtrees[t].begin; --s)
                backward(s, lanes, points, work.spaces[t].data());
        });
    }

    typename Pool<Workspace>::Lease take() const
    {
        return workspaces.take([&] {
            auto work = std::make_unique<Workspace>();
            int tallest = 0;
            for (int s = 0; s < f.supernodes; ++s)
                tallest = std::max(tallest, height(s));
            work->sums.assign(subtrees.size(),
                              std::vector<T>(static_cast<std::size_t>(top_count) * lane_count));
            work->spaces.assign(subtrees.size() + 1, std::vector<T>(LaneSupernode<T>::workspace(tallest)));
            return work;
        });
    }

    /// fill(points) writes the right-hand sides as points of four lanes in the order of elimination;
    /// read(points) gets the solutions in the same layout.
    template <class Fill, class Read>
    void run(int lanes, Fill&& fill, Read&& read) const
    {
        const auto work = take();
        work->points.resize(static_cast<std::size_t>(f.size) * lane_count);
        T* points = work->points.data();
        fill(points);
        sweep(points, lanes, *work);
        read(points);
    }

    /// Calls body(unknown, lanes) for each point.
    template <class Body>
    void each(T* points, const Body& body) const
    {
        constexpr int grain = 16384;
        parallel_for(
            f.size, [&](int i) { body(f.permutation[i], points + lane_count * static_cast<std::size_t>(i)); },
            grain);
    }

    BasicSupernodalFactor<T> f;
    const LaneKernels<T>& kernels;
    std::vector<T> reciprocals; ///< of the diagonal of the factor
    std::vector<Subtree> subtrees;
    std::vector<char> on_top;
    std::vector<int> top_position; ///< the place of each column among those on top, or -1
    int top_count = 0;
    mutable Pool<Workspace> workspaces;
};

template <class T>
SupernodalSolve<T>::SupernodalSolve(const BasicSupernodalFactor<T>& factor) : impl_(hidden<Impl>(factor))
{
}

template <class T>
void SupernodalSolve<T>::renew(const std::vector<char>& chosen)
{
    impl_->invert_diagonal_blocks(chosen);
}

template <class T>
void SupernodalSolve<T>::solve(const MatrixX& rhs, MatrixX& solution) const
{
    const int k = static_cast<int>(rhs.cols());
    solution.resize(rhs.rows(), k);
    impl_->run(
        std::max(k, 3),
        [&](T* points) {
            impl_->each(points, [&](int unknown, T* point) {
                for (int c = 0; c < lane_count; ++c)
                    point[c] = c < k ? static_cast<T>(rhs(unknown, c)) : T(0);
            });
        },
        [&](T* points) {
            impl_->each(points, [&](int unknown, const T* point) {
                for (int c = 0; c < k; ++c)
                    solution(unknown, c) = point[c];
            });
        });
}

template <class T>
void SupernodalSolve<T>::solve_rows(RowMatrix& x, int first, int k) const
{
    impl_->run(
        std::max(k, 3),
        [&](T* points) {
            impl_->each(points, [&](int unknown, T* point) {
                for (int c = 0; c < lane_count; ++c)
                    point[c] = c < k ? static_cast<T>(x(unknown, first + c)) : T(0);
            });
        },
        [&](T* points) {
            impl_->each(points, [&](int unknown, const T* point) {
                for (int c = 0; c < k; ++c)
                    x(unknown, first + c) = point[c];
            });
        });
}

template <class T>
void SupernodalSolve<T>::sweep(int k, const std::function<void(T*)>& fill,
                               const std::function<void(const T*)>& read) const
{
    impl_->run(std::max(k, 3), fill, read);
}

template class SupernodalSolve<double>;
template class SupernodalSolve<float>;

} // namespace sinew
