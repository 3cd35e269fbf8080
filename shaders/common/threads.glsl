// Which thread this is. The GL backend puts this before every kernel: a dispatch of more than 65,535 groups is
// spread over two dimensions, so the last row may hold groups beyond the last thread.
uint group_index() { return gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x; }
uint group_count() { return (threads + GROUP - 1u) / GROUP; }
uint local_index() { return gl_LocalInvocationID.x; }
uint thread_index() { return group_index() * GROUP + gl_LocalInvocationID.x; }
