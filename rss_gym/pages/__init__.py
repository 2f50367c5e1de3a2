"""The pages that commands write: one self-contained file each, from one template."""
