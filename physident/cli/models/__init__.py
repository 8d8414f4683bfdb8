"""Commands that identify, validate or export a model: identify, validate, compare, payload, drive-gains, base-parameters,
export."""
