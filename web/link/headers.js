// The fields by which a request for a scene says who asks, as Hello does for a session.

/** @param {{tenant: string, token: string}} who @returns {Record<string, string>} */
export function headersOf({ tenant, token }) {
  return {
    ...(token ? { Authorization: `Bearer ${token}` } : {}),
    ...(tenant ? { 'Gnomon-Tenant': tenant } : {}),
  };
}
