/* How HDF5 writes our files: through plain writes that do not fail in HDF5's eyes.
 *
 * The library does not survive a failed write: with data of a full disk still in its caches,
 * closing a dataset or a file may crash the program, and with it the other runs. So this driver
 * keeps the first failure to itself, pretends from then on that all goes well, and writes nothing
 * more. Who made the file asks for the failure at the end (and in between, to stop early), and
 * throws the file away.
 */
#ifndef RK_ENSEMBLE_STORE_HDF5_DRIVER_H
#define RK_ENSEMBLE_STORE_HDF5_DRIVER_H

#include <hdf5.h>

/* Set the driver in an access property list. *failure gets the errno of the first failed write; it
 * must be 0 and live until the file is closed. Returns the driver (or an invalid id), for the
 * caller to give back with H5FDunregister once the file is closed and not before: a file that
 * holds the last reference frees the driver and then calls it (H5FD_close of HDF5 1.10). */
hid_t rk_h5_driver_set(hid_t access, int *failure);

#endif
