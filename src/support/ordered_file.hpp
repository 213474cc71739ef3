#pragma once
// An HDF5 driver for files that grow, and must open at any moment: also when the process is killed between any two of
// its writes.
//
// HDF5 writes a file's parts in the order of their places, so that for a moment a table may be longer than its index
// knows of, or an index point to parts that are not there yet. Here nothing reaches the file before it is flushed, and
// then in this order:
//   1. what lies in new space, which nothing in the file points to yet, and data of rows that do not count yet,
//   2. the superblock, which says how large the file is,
//   3. indices, the upper nodes of a tree first: a node that is split has its second half in new space already,
//   4. object headers, which hold the lengths of tables.
// Each of these is one write within a page of memory, which a signal does not cut. Before the first one the file is
// given the space it will need, and more, which closing takes back: on a full disk a flush fails with the file as it
// was, and a reader, who asks for the size of the file before he reads what it should be, seldom meets it growing.
// Frees nothing: for files whose parts are added only.
#include <hdf5.h>

namespace dovetail::h5 {

/// Makes files created with this list of file access properties such files, or says that it cannot.
bool use_ordered_driver(hid_t access);

} // namespace dovetail::h5
