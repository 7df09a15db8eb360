// runtime/comm/halo.hpp: ghosts. Which grains a rank shows to which others, and the messages of a step.
//
// A ghost keeps its owner's coordinates, unshifted; the shift that brings it near the receiver serves the lists only. Grains go
// in chunks, one for each of the sender's tiles within twice the reach of the receiver, and each chunk tells how far the tile's grains
// moved since the lists were built, even when none of them is a ghost: a grain beyond the halo may be on its way here.
// Messages are persistent requests; one message a step and neighbour. A rank may be its own neighbour (a periodic image).
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/slice_grid.hpp"
#include "runtime/comm/communicator.hpp"
#include "runtime/subdomain.hpp"

namespace talus::runtime {

class Halo {
public:
    explicit Halo(Communicator& comm);
    ~Halo();

    /// Find neighbours and exchange whole records; ghosts are appended to the subdomain. [collective]
    /// Owned grains must stand in their tiles.
    void build(const core::SliceGrid& slices, const core::Domain& domain, double reach, Subdomain& sub);

    int n_neighbours() const;
    /// Whether a message goes or comes at all.
    bool talks() const;
    /// Tiles whose grains go to neighbour k.
    const std::vector<int>& tiles_of(int k) const;

    /// Pack the grains for neighbour k and send them. Needs the integrated tiles of k only.
    void send(int k, const Subdomain& sub);
    /// Post the receives of one message a neighbour.
    void start_receives();
    /// Let MPI go on with what is under way, both ways: long messages move only inside its calls, so a neighbour that waits cannot
    /// fetch its own alone. @return true when nothing is awaited; false too while another worker is asking
    bool arrived();
    /// The ghosts are written in so many parts, which may be written at once.
    int n_parts() const;
    /// Write a part of what arrived into the ghosts.
    void take(int part, Subdomain& sub);
    /// Send and take one message a neighbour, between steps. [collective]
    void refresh(Subdomain& sub);
    /// Wait for what is under way, both ways; nothing is written.
    void drain();

    /// That this rank sends in a step.
    std::int64_t bytes_per_step() const;

private:
    struct Send;
    struct Receive;
    struct Part;
    struct Requests;

    void release();

    Communicator& comm_;
    std::vector<Send> sends_;
    std::vector<Receive> receives_;
    std::vector<Part> parts_;
    std::unique_ptr<Requests> requests_;
    bool receiving_ = false, sending_ = false;
};

} // namespace talus::runtime
