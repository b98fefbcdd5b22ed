/* A joint of a member, as passed to a user stage. Right-handed, +Y up, +Z front; metres, radians,
   seconds. */
typedef struct {
    /* After Pose, to read and write: the local transform. */
    float4 translation;   /* x y z 0 */
    float4 rotation;      /* quaternion x y z w; normalised afterwards */
    float4 scale;         /* x y z 0 */
    /* After Transform, to read and write: model_from_joint as three rows; w is the translation. */
    float4 row0;
    float4 row1;
    float4 row2;
    /* Place of the member in the world. */
    float4 place;         /* x y z, and the member's scale */
    float4 facing;        /* sine and cosine of the heading, 0 0: (0, 1) is +Z, (1, 0) is +X */
    float4 values;        /* the member's own values, as given with its use of the stage */
    float parameters[16]; /* as passed to set_stage_parameters; 0 if not set */
    ulong ticks;          /* since the crowd began, 705,600 per second; exact, see stage_phase */
    float elapsed_secs;   /* since the previous frame */
    uint joint;           /* in level order */
    uint member;          /* the member's number, unique in the crowd */
} StageJoint;
