"""Augments crops: mirrored or not, shifted, with noise and in another tint."""

from __future__ import annotations

import jax
import jax.numpy as jnp
from jax import Array

SHIFT = 2
"""Largest shift of a crop in training; pixels of 32."""
NOISE = 0.02
"""Standard deviation of the noise on a crop, for values in 0..1."""
SAME_NOISE = 8
"""Number of crops in a batch that share noise, which is the slowest part of `varied`."""
TINT = 0.5
"""Largest scaling of the channels for the brightness; natural logarithm."""


def varied(key: Array, crop: Array, noise: Array) -> tuple[Array, Array]:
    """Augments a crop `[3, 32, 32]`: mirrored or not, shifted by up to `SHIFT` pixels, with noise;
    also returns its tint.

    Without this, a few thousand crops are soon memorised. The tint (see `encode_views`) keeps
    colour out of the features for shapes: how much a block's brightness differs from the table's
    depends on its colour.
    """
    mirror, shift, tint = jax.random.split(key, 3)
    crop = jnp.where(jax.random.bernoulli(mirror), crop[:, :, ::-1], crop)
    row, column = jax.random.randint(shift, (2,), 0, 2 * SHIFT + 1)
    wide = jnp.pad(crop, ((0, 0), (SHIFT, SHIFT), (SHIFT, SHIFT)), mode="edge")
    moved = jax.lax.dynamic_slice(wide, (0, row, column), crop.shape)
    tints = jnp.exp(jax.random.uniform(tint, (3, 1, 1), minval=-TINT, maxval=TINT))
    return moved + NOISE * noise, tints


def varied_crops(key: Array, crops: Array) -> tuple[Array, Array]:
    """A batch of augmented crops `[N, 3, 32, 32]`, and their tints."""
    varying, noise = jax.random.split(key)
    fields = jax.random.normal(noise, (-(-len(crops) // SAME_NOISE), *crops.shape[1:]))
    fields = jnp.tile(fields, (SAME_NOISE, 1, 1, 1))[: len(crops)]
    return jax.vmap(varied)(jax.random.split(varying, len(crops)), crops, fields)
